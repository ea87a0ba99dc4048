// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/error.hpp"
#include "drivers/line/line_codec.hpp"
#include "drivers/line/serial_wire.hpp"
#include "drivers/link_log.hpp"

namespace cmm::drivers::line {

/// Questions and their answers over one serial port, a stop beside them; each is known by its tag. Used on the thread
/// of its io_context, which outlives it; only log() is for every thread.
class Conversation {
  public:
    Conversation(boost::asio::io_context& io, const SerialSettings& settings);

    /// Opens the port, or opens it anew. Returns why it failed; empty: it is open.
    std::string open() { return wire_.open(); }
    bool is_open() const noexcept { return wire_.is_open(); }
    /// Asks and asks again under the same tag, so that a late answer is one too. `body` is called for each attempt;
    /// an answer is missing after `timeout_ms` and the time on the line. One question at a time. Errors: transport_*,
    /// the port is closed then.
    boost::asio::awaitable<core::Result<Message>> ask(std::function<std::string()> body, std::size_t longest_reply,
                                                      double timeout_ms);
    /// Sends a stop before whatever waits to be written, and again until it is answered. A few attempts are enough: a
    /// controller that cannot be reached stops by its watchdog. `kind`: 1 controlled, 2 emergency.
    void want_stop(int kind, std::chrono::steady_clock::time_point requested);
    LinkLog& log() noexcept { return log_; }
    const LinkLog& log() const noexcept { return log_; }

  private:
    boost::asio::awaitable<void> serve_stop();
    void take(std::span<const std::uint8_t> bytes);
    std::uint16_t next_tag() { return last_tag_ = static_cast<std::uint16_t>(last_tag_ % 65535U + 1U); }

    boost::asio::io_context& io_;
    std::string device_;
    LinkLog log_;
    boost::asio::steady_timer reply_, stop_reply_;
    Parser parser_;
    std::vector<Message> arrived_;
    std::uint16_t last_tag_ = 0, awaited_tag_ = 0, stop_tag_ = 0;  // 0: none
    std::optional<Message> reply_message_;
    int stop_wanted_ = 0;
    bool stopping_ = false;
    std::chrono::steady_clock::time_point stop_requested_{};
    SerialWire wire_;
};

}  // namespace cmm::drivers::line
