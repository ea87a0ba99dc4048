// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/conversation.hpp"

#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <utility>

#include "drivers/as_result.hpp"

namespace cmm::drivers::line {
namespace {

namespace asio = boost::asio;
using Steady = std::chrono::steady_clock;

constexpr int attempts_per_link = 4;  // then the port is opened anew
constexpr int stop_attempts = 4;
constexpr double stop_reply_ms = 100.0;
constexpr std::size_t longest_stop_reply = 260;

}  // namespace

Conversation::Conversation(asio::io_context& io, const SerialSettings& settings)
    : io_(io),
      device_(settings.device),
      reply_(io),
      stop_reply_(io),
      wire_(io, settings, log_, {[this](auto bytes) { take(bytes); }, [this] { reply_.cancel(); }}) {}

void Conversation::take(std::span<const std::uint8_t> bytes) {
    arrived_.clear();
    const std::uint64_t spoilt = parser_.spoilt();
    parser_.feed(bytes, arrived_);
    log_.count([spoilt = parser_.spoilt() - spoilt](LinkStats& stats) { stats.invalid += spoilt; });
    for (Message& message : arrived_) {
        if (awaited_tag_ != 0 && message.tag == awaited_tag_) {
            reply_message_ = std::move(message);
            awaited_tag_ = 0;
            reply_.cancel();
        } else if (stop_tag_ != 0 && message.tag == stop_tag_) {
            stop_tag_ = 0;
            stop_reply_.cancel();
        } else {
            log_.count([](LinkStats& stats) { ++stats.stale; });
        }
    }
}

asio::awaitable<core::Result<Message>> Conversation::ask(std::function<std::string()> body, std::size_t longest_reply,
                                                         double timeout_ms) {
    const std::uint16_t tag = next_tag();
    const auto started = Steady::now();
    for (int attempt = 0; attempt < attempts_per_link && wire_.is_open(); ++attempt) {
        if (attempt > 0) log_.count([](LinkStats& stats) { ++stats.retries; });
        reply_message_.reset();
        awaited_tag_ = tag;
        wire_.send(command_line(tag, body()), false);
        reply_.expires_after(core::from_ms(timeout_ms + wire_.wire_ms(wire_.waiting() + longest_reply)));
        co_await reply_.async_wait(as_result);
        awaited_tag_ = 0;
        if (reply_message_) {
            const std::chrono::duration<double, std::micro> took = Steady::now() - started;
            log_.count([us = took.count()](LinkStats& stats) { stats.add_round_trip(us); });
            co_return std::move(*reply_message_);
        }
        if (wire_.is_open()) log_.count([](LinkStats& stats) { ++stats.timeouts; });
        parser_.reset();
    }
    if (wire_.is_open()) {
        wire_.close();
        co_return core::fail(core::ErrorCode::transport_timeout,
                             device_ + ": nobody answers (check wiring, baud and parity)");
    }
    log_.count([](LinkStats& stats) { ++stats.closed; });
    co_return core::fail(core::ErrorCode::transport_closed, "the port " + device_ + " is gone");
}

void Conversation::want_stop(int kind, Steady::time_point requested) {
    stop_wanted_ = std::max(stop_wanted_, kind);
    if (stopping_) {
        stop_reply_.cancel();  // say it again, with what is wanted now
        return;
    }
    stopping_ = true;
    stop_requested_ = requested;
    asio::co_spawn(io_, serve_stop(), asio::detached);
}

asio::awaitable<void> Conversation::serve_stop() {
    for (int attempt = 0; attempt < stop_attempts && stop_wanted_ != 0; ++attempt) {
        const int kind = stop_wanted_;
        if (!wire_.is_open() && !wire_.open().empty()) break;
        stop_tag_ = next_tag();
        auto written = [this] {
            const std::chrono::duration<double, std::micro> took = Steady::now() - stop_requested_;
            log_.count([us = took.count()](LinkStats& stats) {
                ++stats.stops;
                stats.last_stop_us = us;
            });
        };
        wire_.send(command_line(stop_tag_, "STOP " + std::to_string(kind)), true, written);
        stop_reply_.expires_after(core::from_ms(stop_reply_ms + wire_.wire_ms(wire_.waiting() + longest_stop_reply)));
        co_await stop_reply_.async_wait(as_result);
        const bool answered = stop_tag_ == 0;
        if (answered && stop_wanted_ == kind) stop_wanted_ = 0;
    }
    stop_wanted_ = 0;
    stop_tag_ = 0;
    stopping_ = false;
}

}  // namespace cmm::drivers::line
