// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/rsh_link.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/connect.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <memory>
#include <utility>

#include "core/clock.hpp"
#include "core/text.hpp"
#include "drivers/as_result.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using core::ErrorCode;
using core::Result;
using core::Status;
using SystemError = boost::system::error_code;

/// Outlives the coroutine that connects.
struct Attempt {
    bool late = false, over = false;
};

constexpr std::string_view line_end = "\r\n";

std::span<const std::uint8_t> rsh_bytes_of(const std::string& text) {
    return {static_cast<const std::uint8_t*>(static_cast<const void*>(text.data())), text.size()};
}

/// The reply that a line gets if all is well. Lines come from this driver only.
Reply expectation(const std::string& line) {
    const auto words = core::split(line, ' ');
    Reply reply = read_reply("SET " + std::string(words.size() > 1 ? words[1] : "") + " ACK");
    if (words.front() == "get") reply.kind = Reply::Kind::value;
    if (words.front() == "hello") reply = read_reply("HELLO ACK");
    return reply;
}

bool answers(const Reply& reply, const Reply& expected) {
    using Kind = Reply::Kind;
    if (expected.kind == Kind::hello) return reply.kind == Kind::hello || reply.kind == Kind::stranger;
    if (reply.name != expected.name) return false;
    if (expected.kind == Kind::value) return reply.kind == Kind::value || reply.kind == Kind::not_told;
    return reply.kind == Kind::done || reply.kind == Kind::refused;
}

}  // namespace

RshLink::RshLink(std::string host, std::uint16_t port) : host_(std::move(host)), port_(std::to_string(port)) {
    thread_ = std::thread([this] { io_.run(); });
}

RshLink::~RshLink() {
    io_.stop();
    thread_.join();
}

asio::awaitable<Status> RshLink::open(std::string password, double connect_ms, double reply_ms) {
    auto work = shake_hands(std::move(password), connect_ms, reply_ms);
    co_return co_await asio::co_spawn(io_, std::move(work), asio::use_awaitable);
}

asio::awaitable<Result<Reply>> RshLink::ask(std::string line, double timeout_ms) {
    auto work = in_turn(std::move(line), timeout_ms);
    co_return co_await asio::co_spawn(io_, std::move(work), asio::use_awaitable);
}

asio::awaitable<void> RshLink::acquire() {
    while (taken_)
        co_await turn_.async_wait(as_result);
    taken_ = true;
}

void RshLink::release() {
    taken_ = false;
    turn_.cancel_one();
}

asio::awaitable<Result<Reply>> RshLink::in_turn(std::string line, double timeout_ms) {
    co_await acquire();
    auto reply = co_await exchange(std::move(line), timeout_ms);
    release();
    co_return reply;
}

asio::awaitable<Status> RshLink::shake_hands(std::string password, double connect_ms, double reply_ms) {
    co_await acquire();
    const std::string why = co_await connect(connect_ms);
    Status status;
    if (!why.empty()) status = core::fail(ErrorCode::transport_connect, "cannot connect to " + place() + ": " + why);
    if (status) {
        const auto hello = co_await exchange("hello " + password + " cmmlive 1.0", reply_ms);
        if (!hello) {
            status = tl::unexpected(hello.error());
        } else if (hello->kind == Reply::Kind::stranger) {
            status = core::fail(ErrorCode::protocol_mismatch,
                                "linuxcncrsh at " + place() +
                                    " refuses the password: set connect_password in [linuxcnc] as its --connectpw");
        }
    }
    // Without verbose nothing that is set is acknowledged; the echo of what we say would only be in the way.
    if (status) send({"set echo off", std::nullopt});
    if (status) {
        const auto verbose = co_await exchange("set verbose on", reply_ms);
        if (!verbose) status = tl::unexpected(verbose.error());
    }
    if (!status) close();
    release();
    co_return status;
}

/// Empty, or why not.
asio::awaitable<std::string> RshLink::connect(double timeout_ms) {
    close();
    tcp::resolver resolver(io_);
    const auto attempt = std::make_shared<Attempt>();
    asio::steady_timer limit(io_);
    limit.expires_after(core::from_ms(timeout_ms));
    limit.async_wait([this, &resolver, attempt](const SystemError& error) {
        if (error || attempt->over) return;
        attempt->late = true;
        resolver.cancel();
        SystemError ignored;
        socket_.close(ignored);
    });
    auto [not_found, places] = co_await resolver.async_resolve(host_, port_, as_result);
    SystemError failed = not_found;
    if (!failed && !attempt->late) {
        auto [refused, used] = co_await asio::async_connect(socket_, places, as_result);
        failed = refused;
    }
    attempt->over = true;  // the limit's handler may be on its way already
    limit.cancel();
    if (attempt->late) co_return "nobody answers";
    if (failed) co_return failed.message();
    SystemError ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    splitter_.restart(true);
    is_open_ = true;
    read_on();
    co_return std::string();
}

asio::awaitable<Result<Reply>> RshLink::exchange(std::string line, double timeout_ms) {
    if (!is_open_) co_return core::fail(ErrorCode::transport_closed, "not connected to " + place());
    const auto started = Steady::now();
    awaited_ = expectation(line);
    reply_.reset();
    send({std::move(line), std::nullopt});
    reply_due_.expires_after(core::from_ms(timeout_ms));
    co_await reply_due_.async_wait(as_result);
    awaited_.reset();
    if (reply_) {
        const std::chrono::duration<double, std::micro> took = Steady::now() - started;
        log_.count([us = took.count()](LinkStats& stats) { stats.add_round_trip(us); });
        co_return std::move(*reply_);
    }
    if (!is_open_) {
        log_.count([](LinkStats& stats) { ++stats.closed; });
        co_return core::fail(ErrorCode::transport_closed, "linuxcncrsh at " + place() + " has closed the connection");
    }
    log_.count([](LinkStats& stats) { ++stats.timeouts; });
    close();
    co_return core::fail(ErrorCode::transport_timeout, "linuxcncrsh at " + place() + " does not answer");
}

void RshLink::send(Outgoing line) {
    line.text += line_end;
    outgoing_.push_back(std::move(line));
    if (!writing_) write_on();
}

void RshLink::write_on() {
    if (outgoing_.empty() || !is_open_) return;
    writing_ = true;
    const std::string& text = outgoing_.front().text;
    log_.sent(rsh_bytes_of(text));
    asio::async_write(socket_, asio::buffer(text), [this, link = link_number_](const SystemError& error, std::size_t) {
        if (link != link_number_) return;
        if (error) return lose();
        const auto requested = outgoing_.front().stop_requested;
        outgoing_.pop_front();
        writing_ = false;
        if (requested) {
            const std::chrono::duration<double, std::micro> took = Steady::now() - *requested;
            log_.count([us = took.count()](LinkStats& stats) {
                ++stats.stops;
                stats.last_stop_us = us;
            });
        }
        write_on();
    });
}

void RshLink::read_on() {
    socket_.async_read_some(asio::buffer(buffer_),
                            [this, link = link_number_](const SystemError& error, std::size_t count) {
                                if (link != link_number_) return;
                                if (error) return lose();
                                take(std::span<const std::uint8_t>(buffer_).first(count));
                                if (link == link_number_) read_on();
                            });
}

void RshLink::take(std::span<const std::uint8_t> bytes) {
    log_.received(bytes);
    lines_.clear();
    splitter_.feed(bytes, lines_);
    for (const auto& line : lines_)
        hear(read_reply(line.text));
}

void RshLink::hear(Reply reply) {
    if (awaited_ && answers(reply, *awaited_)) {
        reply_ = std::move(reply);
        awaited_.reset();
        reply_due_.cancel();
    } else if (stops_unanswered_ > 0 && (reply.name == "ABORT" || reply.name == "ESTOP")) {
        --stops_unanswered_;
    } else if (reply.kind == Reply::Kind::meaningless) {
        const bool echo = reply.name == "ECHO" || reply.name == "VERBOSE";  // may come before the echo is off
        if (!echo) log_.count([](LinkStats& stats) { ++stats.invalid; });
    } else {
        log_.count([](LinkStats& stats) { ++stats.stale; });
    }
}

void RshLink::lose() {
    close();
    reply_due_.cancel();
}

void RshLink::close() noexcept {
    ++link_number_;
    is_open_ = false;
    outgoing_.clear();
    writing_ = false;
    stops_unanswered_ = 0;
    SystemError ignored;
    socket_.close(ignored);
}

void RshLink::stop(StopKind kind) noexcept {
    const auto requested = Steady::now();
    try {
        asio::post(io_, [this, kind, requested] {
            if (!is_open_) return;
            ++stops_unanswered_;
            send({kind == StopKind::emergency ? "set estop on" : "set abort", requested});
        });
    } catch (...) {  // no memory for a message: whoever waits for the motion tells it again
    }
}

}  // namespace cmm::drivers::linuxcnc
