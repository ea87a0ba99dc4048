// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cmm::web {

/// What the routes look at of an HTTP request; the server has bounded every length.
struct Request {
    std::string method, target;
    std::string host, origin;
    std::string token;  ///< of "Authorization: Bearer", or of a WebSocket's subprotocol "cmmlive.token.<token>"
    std::string content_type, body;
};

struct Response {
    int status = 200;
    std::string content_type = "application/json; charset=utf-8";
    std::string body;
    std::vector<std::pair<std::string, std::string>> headers;  ///< beside those that every answer has
};

/// {"error": ...}: why, in a sentence for a person.
Response refusal(int status, std::string_view why);

}  // namespace cmm::web
