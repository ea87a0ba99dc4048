// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "acquisition/operator_choice.hpp"
#include "acquisition/scan_job.hpp"
#include "app/commands.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "web/server/page_server.hpp"

namespace cmm::app {

/// The options of a command as the page's.
web::PageOptions page_options(const PageSettings& settings);
/// How a job stands, as /api/status shows it: fields of a JSON object.
std::string job_status(double share, const std::string& text, const drivers::Machine& machine);
/// Until SIGINT or SIGTERM.
void wait_for_end();

/// The page of one running job, if it was asked for; without that every call does nothing.
class RunPage {
  public:
    /// What it is given outlives `end`, the hub outlives this object. Errors: those of PageServer::start.
    core::Status start(const PageSettings& settings, const std::string& folder, acquisition::ScanJob& job,
                       drivers::Machine& machine, acquisition::EventHub& events);
    /// How far the job is; the thread that drives it.
    void show(double share, const std::string& text);
    /// The job has ended; the page goes on with its run file.
    acquisition::OperatorChoice end();
    /// Empty: there is none.
    std::string url() const { return server_ ? server_->url() : std::string(); }

  private:
    mutable std::mutex mutex_;
    double share_ = 0.0;
    std::string text_;
    std::unique_ptr<web::PageServer> server_;  // asks for the status until it is destroyed
};

}  // namespace cmm::app
