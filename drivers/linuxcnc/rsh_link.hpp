// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "drivers/dro/line_splitter.hpp"
#include "drivers/link_log.hpp"
#include "drivers/linuxcnc/rsh_reply.hpp"
#include "drivers/machine.hpp"

namespace cmm::drivers::linuxcnc {

/// One connection to linuxcncrsh on a thread of its own, so that a stop goes out whatever the run is busy with. One
/// question at a time: replies carry no number, only the name of what was asked for. Hence a reply that did not come in
/// time ends the connection: late, it would be taken for the next one's. Coroutines may be awaited on any executor, and
/// must have ended before the link does.
class RshLink {
  public:
    RshLink(std::string host, std::uint16_t port);
    ~RshLink();
    RshLink(const RshLink&) = delete;
    RshLink& operator=(const RshLink&) = delete;

    /// Connects anew and says hello; changes nothing at the machine. Errors: transport_connect, transport_timeout,
    /// transport_closed, protocol_mismatch (wrong password, or no linuxcncrsh).
    boost::asio::awaitable<core::Status> open(std::string password, double connect_ms, double reply_ms);
    /// "get ..." or "set ...", and its reply. Errors: transport_timeout, transport_closed.
    boost::asio::awaitable<core::Result<Reply>> ask(std::string line, double timeout_ms);
    bool is_open() const noexcept { return is_open_; }
    /// Any thread: does not wait for the question under way.
    void stop(StopKind kind) noexcept;
    LinkLog& log() noexcept { return log_; }
    const LinkLog& log() const noexcept { return log_; }

  private:
    using Steady = std::chrono::steady_clock;
    struct Outgoing {
        std::string text;
        std::optional<Steady::time_point> stop_requested;
    };

    boost::asio::awaitable<core::Status> shake_hands(std::string password, double connect_ms, double reply_ms);
    boost::asio::awaitable<std::string> connect(double timeout_ms);
    boost::asio::awaitable<core::Result<Reply>> in_turn(std::string line, double timeout_ms);
    boost::asio::awaitable<core::Result<Reply>> exchange(std::string line, double timeout_ms);
    boost::asio::awaitable<void> acquire();
    void release();
    void send(Outgoing line);
    void write_on();
    void read_on();
    void take(std::span<const std::uint8_t> bytes);
    void hear(Reply reply);
    void lose();
    void close() noexcept;
    std::string place() const { return host_ + ":" + port_; }

    std::string host_, port_;
    LinkLog log_;
    std::atomic<bool> is_open_{false};
    // The thread's own.
    boost::asio::io_context io_{1};
    boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_{io_.get_executor()};
    boost::asio::ip::tcp::socket socket_{io_};
    boost::asio::steady_timer turn_{io_, Steady::time_point::max()};
    boost::asio::steady_timer reply_due_{io_};
    bool taken_ = false;
    bool writing_ = false;
    int stops_unanswered_ = 0;
    std::uint64_t link_number_ = 0;  // handlers of an earlier connection are told by it
    std::deque<Outgoing> outgoing_;
    std::array<std::uint8_t, 4096> buffer_{};
    dro::LineSplitter splitter_;
    std::vector<dro::LineSplitter::Line> lines_;
    std::optional<Reply> awaited_;  // kind and name as they would be if all is well
    std::optional<Reply> reply_;
    std::thread thread_;  // last: everything else exists when it starts
};

}  // namespace cmm::drivers::linuxcnc
