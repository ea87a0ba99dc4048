// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <memory>
#include <mutex>
#include <string>

#include "acquisition/workers.hpp"
#include "app/cell_programs.hpp"
#include "app/cell_run.hpp"
#include "app/cell_view.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "cell/cell_front.hpp"
#include "cell/mqtt_publisher.hpp"
#include "core/clock.hpp"
#include "drivers/machine_file.hpp"
#include "web/server/page_server.hpp"

namespace cmm::app {

/// Part after part for a PLC: the cell's front on a thread of its own, the runs, their files and the record of what the
/// PLC was told on the thread of `serve`, one after another.
class CellService {
  public:
    CellService(CellSettings settings, const core::Clock& clock);

    /// Reads what it is given, and listens. Errors: usage, input_missing, input_invalid, those of machine files.
    core::Status start();
    /// Where the PLC finds its registers.
    std::string url() const;
    /// Empty: there is no page.
    std::string page_url() const { return page_ ? page_->url() : std::string(); }
    const CellPrograms& programs() const { return programs_; }
    /// Until `end_orderly`; the machine rests then, as far as is known.
    void serve();
    /// Any thread: the run under way is stopped, its result recorded for the PLC.
    void end_orderly();
    /// Any thread: the machine is told to stop once more, and the process is gone.
    void abort();

  private:
    void keep(const cell::CellRecord& record);
    core::Status start_page();
    core::Status start_mqtt();
    void tell(const cell::CellView& view);
    void tell(const acquisition::Event& event, const cell::Order& order);
    void run(const cell::Order& order);
    void show(double share, const std::string& text);
    void begin_page();
    void ended();
    void finish_run();
    void end_when_at_rest();

    CellSettings settings_;
    const core::Clock& clock_;
    CellPrograms programs_;
    drivers::LinkSettings link_;
    std::string record_file_, host_;
    Progress progress_;
    acquisition::Workers workers_;
    boost::asio::io_context context_{1};
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{context_.get_executor()};
    std::mutex run_mutex_;               // of these two: a stop comes from another thread
    std::unique_ptr<CellRun> run_;       // set by the thread of `serve`
    bool stop_asked_ = false;            // also before there is a run
    mutable std::mutex progress_mutex_;  // of these two
    double share_ = 0.0;
    std::string text_;
    CellMetrics metrics_;
    std::unique_ptr<cell::MqttPublisher> mqtt_;
    std::unique_ptr<cell::CellFront> front_;  // uses the above until it is destroyed
    std::unique_ptr<web::PageServer> page_;   // likewise
};

}  // namespace cmm::app
