// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/strand.hpp>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "acquisition/events.hpp"
#include "acquisition/scan_job.hpp"
#include "acquisition/workers.hpp"
#include "cell/outcome.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"
#include "drivers/machine.hpp"
#include "drivers/machine_file.hpp"

namespace cmm::app {

/// What a run of the cell tells while it goes on and when it ends.
struct CellRunHooks {
    /// Section from 1 on; a text now and then, otherwise none. The run's thread.
    std::function<void(double share, std::size_t section, const std::string& text)> progress;
    std::function<void(std::size_t section, core::Duration arrived)> rejected;  ///< for certain; any thread
    std::function<void(cell::Reason)> held;  ///< it waits at rest, none: it goes on; any thread
    std::function<void()> ended;             ///< the run's thread
};

/// One part on the machine: a scan job with everything it needs, from the part file to the files in its folder. Made,
/// begun and destroyed on the thread of `context`; stopped from any.
class CellRun {
  public:
    struct Order {
        std::string part_file, serial, folder;
        bool stop_when_rejected = false;
        double wait_s = -1.0;  ///< negative: as the part file says
    };
    CellRun(boost::asio::io_context& context, const drivers::LinkSettings& link, const core::Clock& clock,
            acquisition::Workers& workers, CellRunHooks hooks);

    /// Reads the part file and makes the job. Errors: what is wrong with it; then there is no run.
    core::Status prepare(const Order& order);
    /// Runs the job; `hooks.ended` follows.
    void begin();
    void stop() noexcept { job_->request_stop(); }
    /// The files beside the run file, after the end. Errors: journal_io, journal_full.
    core::Status write_files() const;

    drivers::Machine& machine() { return *machine_; }
    acquisition::ScanJob& job() { return *job_; }
    acquisition::EventHub& events() { return events_; }
    const std::string& folder() const { return folder_; }
    /// After the end.
    acquisition::ScanOutcome& outcome() { return *outcome_; }

  private:
    boost::asio::awaitable<void> go();
    void hear(const acquisition::Event& event);

    boost::asio::strand<boost::asio::io_context::executor_type> strand_;
    const drivers::LinkSettings& link_;
    const core::Clock& clock_;
    acquisition::Workers& workers_;
    CellRunHooks hooks_;
    acquisition::EventHub events_;
    std::unique_ptr<drivers::Machine> machine_;
    std::unique_ptr<acquisition::ScanJob> job_;
    std::string folder_;
    std::optional<acquisition::ScanOutcome> outcome_;
    double share_ = 0.0;
    std::size_t section_ = 0;  // from 1 on; both of the strand
    double latency_ms_ = 0.0;  // of the newest section; one event at a time
};

/// What a PLC hears of an outcome.
cell::Outcome cell_outcome(const acquisition::ScanOutcome& outcome);

}  // namespace cmm::app
