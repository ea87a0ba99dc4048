// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/rsh_session.hpp"

#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <utility>

#include "core/text.hpp"
#include "drivers/as_result.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

namespace asio = boost::asio;
using core::ErrorCode;
using core::Motion;
using core::Result;
using core::Status;

constexpr double first_rsh_backoff_ms = 20.0;
constexpr double longest_rsh_backoff_ms = 250.0;
// linuxcncrsh looks only every 100 ms whether a command has arrived, and an emergency stop takes two such turns.
constexpr double command_reply_ms = 3000.0;
constexpr double switch_patience_ms = 3000.0;  // the emergency stop goes through a loop of 100 ms turns
constexpr int most_messages = 64;              // LinuxCNC's queue is shorter

core::Error meaningless(const std::string& what, const std::string& text) {
    return core::Error{
        ErrorCode::protocol_invalid, "linuxcncrsh answers \"" + text + "\" to `get " + what + "`", {}, Motion::unknown};
}

}  // namespace

core::Error emergency_error() {
    return core::Error{ErrorCode::machine_emergency, "LinuxCNC is in emergency stop", {}, Motion::stopped};
}

RshSession::RshSession(const LinkSettings& settings, const DriverContext& context)
    : settings_(settings),
      clock_(context.clock),
      executor_(context.executor),
      link_(settings.endpoint.host, settings.endpoint.port) {}

double RshSession::now_ms() const noexcept {
    return 1e3 * core::seconds(clock_.now());
}

asio::awaitable<void> RshSession::pause(double ms) {
    asio::steady_timer timer(executor_);
    timer.expires_after(core::from_ms(ms));
    co_await timer.async_wait(as_result);
}

asio::awaitable<Status> RshSession::connect() {
    const std::string password = settings_.linuxcnc.connect_password;
    const auto open = co_await link_.open(password, settings_.connect_timeout_ms, settings_.response_timeout_ms);
    if (!open) co_return open;
    const std::string question = "get user_linear_units";
    const auto unit = co_await link_.ask(question, settings_.response_timeout_ms);
    if (!unit) co_return tl::unexpected(unit.error());
    const auto unit_mm = read_unit_mm(unit->text);
    if (!unit_mm) {
        co_return core::fail(ErrorCode::protocol_mismatch,
                             "LinuxCNC's length unit is \"" + unit->text +
                                 "\"; mm, cm and inch are understood ([TRAJ] LINEAR_UNITS of its ini file)");
    }
    unit_mm_ = *unit_mm;
    co_return Status{};
}

asio::awaitable<Status> RshSession::open() {
    in_control_ = false;
    auto open = co_await connect();
    known_ = open.has_value();
    co_return open;
}

/// After a link was lost: as it was before.
asio::awaitable<Status> RshSession::relink() {
    while (relinking_)
        co_await pause(look_every_ms);
    if (link_.is_open()) co_return Status{};
    if (!known_) co_return core::fail(ErrorCode::transport_closed, "not connected to LinuxCNC");
    relinking_ = true;
    auto status = co_await connect();
    if (status) link_.log().count([](LinkStats& stats) { ++stats.reconnects; });
    if (status && in_control_) status = co_await claim();
    relinking_ = false;
    co_return status;
}

asio::awaitable<Status> RshSession::claim() {
    const std::string enable = "set enable " + settings_.linuxcnc.enable_password;
    const auto enabled = co_await link_.ask(enable, settings_.response_timeout_ms);
    if (!enabled) co_return tl::unexpected(enabled.error());
    if (enabled->kind != Reply::Kind::done) {
        co_return core::fail(ErrorCode::protocol_mismatch,
                             "linuxcncrsh refuses control: set enable_password in [linuxcnc] as its --enablepw");
    }
    // Not "done": linuxcncrsh would answer nothing, not even a stop, until the motion has ended.
    const std::string wait = "set set_wait received";
    const auto waiting = co_await link_.ask(wait, settings_.response_timeout_ms);
    if (!waiting) co_return tl::unexpected(waiting.error());
    if (waiting->kind == Reply::Kind::done) co_return Status{};
    co_return core::fail(ErrorCode::protocol_mismatch, "linuxcncrsh refuses `set set_wait received`");
}

asio::awaitable<Status> RshSession::take_control() {
    auto status = co_await relink();
    if (status) status = co_await claim();
    in_control_ = status.has_value();
    co_return status;
}

asio::awaitable<Status> RshSession::give_control_back() {
    if (!in_control_) co_return Status{};
    in_control_ = false;
    if (!link_.is_open()) co_return Status{};  // it went with the connection
    const std::string off = "set enable off";
    const auto reply = co_await link_.ask(off, settings_.response_timeout_ms);
    if (!reply) co_return tl::unexpected(reply.error());
    co_return Status{};
}

asio::awaitable<Result<Reply>> RshSession::ask(std::string line) {
    const auto linked = co_await relink();
    if (!linked) co_return tl::unexpected(linked.error());
    const bool command = line.starts_with("set");
    const double timeout_ms = std::max(settings_.response_timeout_ms, command ? command_reply_ms : 0.0);
    co_return co_await link_.ask(std::move(line), timeout_ms);
}

asio::awaitable<Result<std::string>> RshSession::get(std::string what) {
    double give_up_ms = 0.0;
    for (double backoff_ms = first_rsh_backoff_ms;; backoff_ms = std::min(2.0 * backoff_ms, longest_rsh_backoff_ms)) {
        std::string line = "get " + what;
        auto reply = co_await ask(std::move(line));
        if (reply && reply->kind == Reply::Kind::value) co_return std::move(reply->text);
        if (reply) {
            co_return core::fail(ErrorCode::protocol_mismatch,
                                 "linuxcncrsh does not know `get " + what + "`: versions 2.8 and 2.9 do");
        }
        if (!core::retryable(reply.error().code)) co_return tl::unexpected(reply.error());
        if (give_up_ms == 0.0) give_up_ms = now_ms() + settings_.reconnect_ms;
        if (now_ms() >= give_up_ms) co_return tl::unexpected(reply.error());
        link_.log().count([](LinkStats& stats) { ++stats.retries; });
        co_await pause(backoff_ms);
    }
}

asio::awaitable<Result<bool>> RshSession::get_switch(std::string what) {
    const auto text = co_await get(what);
    if (!text) co_return tl::unexpected(text.error());
    const auto on = read_switch(*text);
    if (!on) co_return tl::unexpected(meaningless(what, *text));
    co_return *on;
}

asio::awaitable<Result<Eigen::Vector3d>> RshSession::position_mm(std::string what) {
    const auto text = co_await get(what);
    if (!text) co_return tl::unexpected(text.error());
    const auto position = read_position(*text);
    if (!position) co_return tl::unexpected(meaningless(what, *text));
    const Eigen::Vector3d position_mm = *position * unit_mm_;
    co_return position_mm;
}

asio::awaitable<Result<bool>> RshSession::homed() {
    const std::string what = "joint_homed";
    const auto text = co_await get(what);
    if (!text) co_return tl::unexpected(text.error());
    const auto all = read_homed(*text, settings_.linuxcnc.joints);
    if (!all) co_return tl::unexpected(meaningless(what, *text));
    co_return *all;
}

asio::awaitable<Result<Look>> RshSession::look() {
    Look look;
    const auto estop = co_await get_switch("estop");
    if (!estop) co_return tl::unexpected(estop.error());
    const auto on = co_await get_switch("machine");
    if (!on) co_return tl::unexpected(on.error());
    const auto status = co_await get("program_status");
    if (!status) co_return tl::unexpected(status.error());
    look.estop = *estop;
    look.machine_on = *on;
    look.idle = *status == "IDLE";
    co_return look;
}

/// Each question takes one message of whatever kind out of the queue: "OK" from one of them alone means nothing.
asio::awaitable<Status> RshSession::collect(Messages& messages) {
    for (int count = 0; count < most_messages; ++count) {
        bool silent = true;
        for (const std::string_view what : {"error", "operator_display", "operator_text"}) {
            const auto text = co_await get(std::string(what));
            if (!text) co_return tl::unexpected(text.error());
            if (*text == "OK") continue;
            silent = false;
            if (what == "error" && messages.error.empty()) messages.error = *text;
            auto report = read_report(*text);
            if (report) messages.report = std::move(report);
        }
        if (silent) break;
    }
    co_return Status{};
}

asio::awaitable<core::Error> RshSession::refusal(std::string what) {
    core::Error error{ErrorCode::machine_refused, "LinuxCNC refuses `set " + what + "`", {}, Motion::unknown};
    Messages messages;
    if (const auto told = co_await collect(messages); !told) co_return error;
    const auto enabled = co_await get_switch("enable");
    const auto now = co_await look();
    if (!enabled || !now) co_return error;
    if (now->idle) error.motion = Motion::stopped;
    if (!messages.error.empty()) {
        const Motion motion = error.motion;
        error = error_of_text(messages.error);
        error.motion = motion;
    } else if (!*enabled) {
        error.message += ": another client of linuxcncrsh has taken the control";
    } else if (now->estop) {
        error = emergency_error();
    } else if (!now->machine_on) {
        error.message += ": the machine is switched off";
    }
    co_return error;
}

asio::awaitable<Status> RshSession::set(std::string what) {
    std::string line = "set " + what;
    const auto reply = co_await ask(std::move(line));
    if (!reply) co_return tl::unexpected(reply.error());
    if (reply->kind == Reply::Kind::done) co_return Status{};
    core::Error error = co_await refusal(std::move(what));
    co_return tl::unexpected(std::move(error));
}

/// LinuxCNC acknowledges that the wish has arrived; whether it is granted shows later.
asio::awaitable<Status> RshSession::set_switch(std::string what, bool on, ErrorCode failure) {
    std::string line = what + (on ? " on" : " off");
    auto told = co_await set(std::move(line));
    if (!told) co_return told;
    const double give_up_ms = now_ms() + switch_patience_ms;
    for (;;) {
        const auto is_on = co_await get_switch(what);
        if (!is_on) co_return tl::unexpected(is_on.error());
        if (*is_on == on) co_return Status{};
        if (now_ms() >= give_up_ms) break;
        co_await pause(look_every_ms);
    }
    Messages messages;
    const auto collected = co_await collect(messages);
    std::string why = collected && !messages.error.empty() ? ": " + messages.error : std::string();
    co_return core::fail(failure,
                         "LinuxCNC does not switch \"" + what + "\" " + (on ? "on" : "off") +
                             "; what holds it is wired in its HAL files" + why,
                         Motion::stopped);
}

asio::awaitable<Status> RshSession::set_mode(std::string mode) {
    const double give_up_ms = now_ms() + switch_patience_ms;
    for (bool told = false;; told = true) {
        const auto present = co_await get("mode");
        if (!present) co_return tl::unexpected(present.error());
        if (*present == mode) co_return Status{};
        if (now_ms() >= give_up_ms) break;
        if (told) {
            co_await pause(look_every_ms);
            continue;
        }
        std::string line = "mode " + mode;
        auto done = co_await set(std::move(line));
        if (!done) co_return done;
    }
    Messages messages;
    const auto collected = co_await collect(messages);
    if (collected && !messages.error.empty()) co_return tl::unexpected(error_of_text(messages.error));
    co_return core::fail(ErrorCode::machine_refused, "LinuxCNC does not change to mode " + mode, Motion::stopped);
}

void RshSession::stop(StopKind kind) noexcept {
    const int wanted = kind == StopKind::emergency ? 2 : 1;
    int present = stop_asked_;
    while (present < wanted && !stop_asked_.compare_exchange_weak(present, wanted)) {
    }
    if (in_control_) link_.stop(kind);
}

}  // namespace cmm::drivers::linuxcnc
