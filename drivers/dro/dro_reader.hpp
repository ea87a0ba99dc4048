// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.hpp"
#include "core/error.hpp"
#include "drivers/dro/line_format.hpp"
#include "drivers/dro/line_splitter.hpp"
#include "drivers/line/serial_wire.hpp"
#include "drivers/link_log.hpp"
#include "drivers/serial_settings.hpp"

namespace cmm::drivers::dro {

/// A line, and when its last byte came (host clock).
struct Heard {
    LineContent content;
    std::string text;
    core::Duration at{};
};

/// Listens to a serial port on a thread of its own, so that no line is missed whatever the run is busy with. Its
/// functions are for one other thread; the log for any. Garbled lines are counted in the log as invalid, all others as
/// ok. The clock outlives it.
class DroReader {
  public:
    DroReader(const SerialSettings& serial, LineFormat format, const core::Clock& clock);
    ~DroReader();
    DroReader(const DroReader&) = delete;
    DroReader& operator=(const DroReader&) = delete;

    /// Also after the port was lost. Errors: transport_connect.
    core::Status open();
    /// The port is gone since it was opened.
    bool lost() const noexcept { return lost_; }
    /// The next line; nothing: none has come.
    std::optional<Heard> next();
    /// Gives up the lines that wait.
    void forget();
    void send(const std::string& text);
    LinkLog& log() noexcept { return log_; }
    const LinkLog& log() const noexcept { return log_; }

  private:
    void take(std::span<const std::uint8_t> bytes);

    LineFormat format_;
    const core::Clock& clock_;
    LinkLog log_;
    std::atomic<bool> lost_{false};
    mutable std::mutex mutex_;  // of what has been heard
    std::deque<Heard> heard_;
    // The thread's own.
    boost::asio::io_context io_;
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{io_.get_executor()};
    LineSplitter splitter_;
    std::vector<LineSplitter::Line> lines_;
    core::Duration opened_{};
    bool first_bytes_ = true;
    line::SerialWire wire_;
    std::thread thread_;
};

}  // namespace cmm::drivers::dro
