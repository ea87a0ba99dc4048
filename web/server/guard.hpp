// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "web/server/message.hpp"

namespace cmm::web {

/// Who may ask for what, before any route looks at a request. Immutable.
///  - Host: an address, localhost or one of `hosts`. A page of someone else whose name was turned to this address (DNS
///    rebinding) shows its own name here.
///  - Origin, where there is one: this very server.
///  - The token for all that changes something, and with `token_to_read` for all but the page's own files.
class Guard {
  public:
    Guard(std::string token, bool token_to_read, std::vector<std::string> hosts)
        : token_(std::move(token)), token_to_read_(token_to_read), hosts_(std::move(hosts)) {}

    /// Why a request is refused, whatever it asks for: 400, 403, 405, 415.
    std::optional<Response> refuse(const Request& request) const;
    /// 401 without the token. For routes of the API.
    std::optional<Response> refuse_api(const Request& request) const;

  private:
    bool known_host(const std::string& host) const;

    std::string token_;
    bool token_to_read_;
    std::vector<std::string> hosts_;
};

}  // namespace cmm::web
