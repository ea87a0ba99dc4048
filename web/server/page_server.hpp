// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/events.hpp"
#include "acquisition/operator_choice.hpp"
#include "core/error.hpp"
#include "web/server/api.hpp"

namespace cmm::web {

struct PageOptions {
    std::string listen = "127.0.0.1:8686";  ///< ADDRESS:PORT, an IPv6 address in brackets; port 0: a free one
    std::string token_file;                 ///< empty: a new token each time
    std::vector<std::string> hosts;         ///< names beside addresses and localhost that pages may ask for
    std::string runs_folder;                ///< whose runs are shown; empty: only the job's
    std::string version;
};

/// The page: server, routes, guard and the newest events of a job, started together. Serves until it is destroyed; its
/// destructor does not wait for pages. Any thread.
class PageServer {
  public:
    /// `hub` (nullptr: no job) is listened to from now on and outlives this object. Another address than this machine's
    /// own needs a token file, and then reading needs the token too. Errors: usage, input_missing, config_invalid.
    static core::Result<std::unique_ptr<PageServer>> start(const PageOptions& options, std::optional<LiveJob> job,
                                                           acquisition::EventHub* hub, ServiceView view = {});
    ~PageServer();
    PageServer(const PageServer&) = delete;
    PageServer& operator=(const PageServer&) = delete;

    /// Where a browser finds it, the token in the fragment, which browsers do not send.
    const std::string& url() const;
    /// Another job begins, the one before has ended. Its hub is listened to from now on.
    void begin_job(LiveJob job, acquisition::EventHub& hub);
    /// Nothing of the job is touched any more. What an operator decided about points while it ran.
    acquisition::OperatorChoice end_job();

  private:
    struct Parts;
    explicit PageServer(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

}  // namespace cmm::web
