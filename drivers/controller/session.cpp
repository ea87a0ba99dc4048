// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/session.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/rng.hpp"
#include "drivers/link_error.hpp"

namespace cmm::drivers::controller {
namespace {

namespace asio = boost::asio;
using Fate = Round::Fate;

constexpr std::uint16_t command_failed = 3;
constexpr std::uint16_t result_refused = 4;
constexpr double claim_again_ms = 50.0;
constexpr double insist_every_ms = 300.0;  // longer than a stop takes that arrives, shorter than the watchdog time
constexpr double busy_patience_ms = 1000.0;
constexpr double stop_patience_ms = 5000.0;  // a machine brakes within a second; afterwards nothing is known

core::Motion motion_of(const StatusBlock& status) {
    return status.in_motion() ? core::Motion::may_be_moving : core::Motion::stopped;
}

}  // namespace

Session::Session(std::unique_ptr<Port> port, double poll_ms, const DriverContext& context)
    : port_(std::move(port)),
      clock_(context.clock),
      poll_ms_(poll_ms),
      owner_(static_cast<std::uint32_t>(core::Rng::keyed(context.seed, 2, 0).below(0xFFFFFFFFU)) + 1U) {}

asio::awaitable<void> Session::pause(double ms) {
    co_await port_->pause(ms);
}

asio::awaitable<core::Result<Capabilities>> Session::open() {
    begun_ = false;
    auto found = co_await port_->open();
    if (found) capabilities_ = *found;
    co_return found;
}

asio::awaitable<core::Result<StatusBlock>> Session::status() {
    Round question;
    question.ask_status = true;
    const auto answered = co_await port_->run(question);
    if (!answered) {
        const core::Error error = lost(answered.error());
        co_return tl::unexpected(error);
    }
    co_return question.status;
}

void Session::stop(StopKind kind) noexcept {
    const int wanted = kind == StopKind::emergency ? 2 : 1;
    int present = stop_asked_.load();
    while (present < wanted && !stop_asked_.compare_exchange_weak(present, wanted)) {
    }
    port_->stop(kind);
}

/// As long as we speak with the controller its watchdog will not do what a lost stop should have done.
void Session::insist() {
    const int asked = stop_asked_;
    if (asked == 0) return;
    const double now_ms = port_->now_ms();
    if (insist_at_ms_ != 0.0 && now_ms < insist_at_ms_) return;
    if (insist_at_ms_ != 0.0) port_->stop(asked == 2 ? StopKind::emergency : StopKind::controlled);
    insist_at_ms_ = now_ms + insist_every_ms;
}

asio::awaitable<core::Status> Session::prepare() {
    stop_asked_ = 0;
    insist_at_ms_ = 0.0;
    if (!begun_) {
        co_return core::fail(core::ErrorCode::machine_refused, "no run has been begun on this machine",
                             core::Motion::not_concerned);
    }
    const auto present = co_await status();
    if (!present) co_return tl::unexpected(present.error());
    if (present->in_motion() || present->command_state == command_running) {
        co_return core::fail(core::ErrorCode::machine_busy, "another motion is under way", core::Motion::may_be_moving);
    }
    // Never back: a status that is older than our last command would give the next one a number that is taken.
    if (static_cast<std::int16_t>(present->command_sequence - command_sequence_) > 0)
        command_sequence_ = present->command_sequence;
    if (present->owner == owner_) co_return core::Status{};
    co_return co_await claim(0.0);
}

asio::awaitable<core::Status> Session::claim(double patience_ms) {
    const double give_up_ms = port_->now_ms() + patience_ms;
    const std::array<std::int32_t, 8> none{};
    for (;;) {
        const auto taken = co_await give(Opcode::claim, none);
        if (taken) co_return core::Status{};
        const bool owned = round_.command_fate == Fate::done && taken.error().code == core::ErrorCode::machine_refused;
        if (!owned || port_->now_ms() >= give_up_ms) co_return tl::unexpected(taken.error());
        co_await pause(claim_again_ms);
    }
}

asio::awaitable<core::Result<StatusBlock>> Session::give(Opcode opcode, std::array<std::int32_t, 8> args) {
    const std::uint16_t previous = command_sequence_;
    ++command_sequence_;
    if (command_sequence_ == 0) ++command_sequence_;  // never used by the protocol
    command_.sequence = command_sequence_;
    command_.opcode = opcode;
    command_.owner = owner_;
    command_.args = args;
    const double give_up_ms = port_->now_ms() + busy_patience_ms;
    core::Status answered;
    for (;;) {
        round_ = Round{};
        round_.command = &command_;
        round_.ask_status = true;
        answered = co_await port_->run(round_);
        if (!answered || round_.command_fate != Fate::busy || port_->now_ms() >= give_up_ms) break;
        co_await pause(poll_ms_);
    }
    // A status from before the command, although the command was answered: the late reply to an earlier question, where
    // replies carry no number.
    const bool stale = answered && round_.command_fate == Fate::done && latest_status().command_sequence == previous;
    if (stale) {
        round_.command = nullptr;
        answered = co_await port_->run(round_);
    }
    if (!answered) {
        const core::Error error = lost(answered.error());
        co_return tl::unexpected(error);
    }
    const StatusBlock taken = latest_status();
    core::Error error{core::ErrorCode::protocol_invalid, "", {}, motion_of(taken)};
    if (round_.command_fate != Fate::done) {
        error.message = "the controller refuses the command block with " + round_.refusal;
        co_return tl::unexpected(error);
    }
    if (taken.command_sequence != command_.sequence) {
        error.code = core::ErrorCode::machine_refused;
        error.message = "another client gave the machine a command";
        co_return tl::unexpected(error);
    }
    if (const auto failed = failure(taken)) co_return tl::unexpected(*failed);
    co_return taken;
}

std::optional<core::Error> Session::failure(const StatusBlock& status) {
    if (status.command_state != command_failed) return std::nullopt;
    // Refused because of a stop or fault before it: that is what the user has to know.
    const bool halted = status.result == result_refused && status.fault != 0;
    core::Error error = error_of_result(halted ? status.fault : status.result);
    error.motion = motion_of(status);
    return error;
}

asio::awaitable<core::Result<StatusBlock>> Session::finish(StatusBlock status, SampleSink* sink) {
    begin_motion();
    while (status.command_state == command_running && is_ours(status)) {
        co_await pause(poll_ms_);
        auto block = co_await exchange(sink, nullptr, true);
        if (!block) {
            core::Error error = co_await abandon(std::move(block.error()));
            co_return tl::unexpected(std::move(error));
        }
        status = latest_status();
    }
    end_motion();
    if (!is_ours(status)) {
        co_return core::fail(core::ErrorCode::machine_refused, "another client gave the machine a command",
                             motion_of(status));
    }
    if (const auto failed = failure(status)) co_return tl::unexpected(*failed);
    co_return status;
}

asio::awaitable<core::Error> Session::abandon(core::Error error) {
    if (is_transport(error.code) || !port_->opened()) {
        core::Error completed = lost(std::move(error));
        end_motion();
        co_return completed;
    }
    end_motion();
    error.motion = core::Motion::unknown;
    stop(StopKind::controlled);
    const double give_up_ms = port_->now_ms() + stop_patience_ms;
    while (port_->now_ms() < give_up_ms) {
        const auto present = co_await status();
        if (!present) break;
        error.motion = motion_of(*present);
        if (!present->in_motion()) break;
        const auto alive = co_await exchange(nullptr, nullptr, false);
        if (!alive) break;
        co_await pause(poll_ms_);
    }
    co_return error;
}

/// After a lost link the machine goes on until its watchdog stops it; whether it did cannot be seen from here.
core::Error Session::lost(core::Error error) const {
    if (error.motion != core::Motion::not_concerned) return error;
    const bool may_move = moving_ && port_->now_ms() - port_->last_answer_ms() < capabilities_.watchdog_ms;
    error.motion = may_move ? core::Motion::may_be_moving : core::Motion::unknown;
    return error;
}

asio::awaitable<core::Result<RunOrigin>> Session::begin(std::optional<RunOrigin> resume) {
    begun_ = false;
    auto present = co_await status();
    if (!present) co_return tl::unexpected(present.error());
    command_sequence_ = present->command_sequence;
    // The owner before us may have been killed a moment ago: its watchdog must run out first.
    const auto claimed = co_await claim(2.0 * capabilities_.watchdog_ms + 1000.0);
    if (!claimed) co_return tl::unexpected(claimed.error());
    present = co_await status();
    if (!present) co_return tl::unexpected(present.error());
    auto origin = take_up(*present, resume);
    if (!origin) co_return origin;
    const auto block = co_await exchange(nullptr, nullptr, false);
    if (!block) {
        const core::Error error = lost(block.error());
        co_return tl::unexpected(error);
    }
    begun_ = true;
    co_return origin;
}

core::Result<RunOrigin> Session::take_up(const StatusBlock& status, const std::optional<RunOrigin>& resume) {
    RunOrigin origin = resume.value_or(RunOrigin{});
    newest_ = status.newest;
    newest_growth_ = 0;
    const bool same_start = resume && resume->boot_id == capabilities_.boot_id;
    if (!same_start) {
        origin.boot_id = capabilities_.boot_id;
        origin.sequence_shift = static_cast<std::int64_t>(origin.last_sequence) - std::int64_t{status.newest};
        reader_.begin(origin, status.newest);
        return origin;
    }
    const std::int64_t last = static_cast<std::int64_t>(origin.last_sequence) - origin.sequence_shift;
    if (last < std::int64_t{status.acknowledged} || last > std::int64_t{status.newest}) {
        return core::fail(core::ErrorCode::protocol_mismatch,
                          "the run cannot be resumed: it ends with the controller's sample " + std::to_string(last) +
                              ", the controller holds " + std::to_string(std::int64_t{status.acknowledged} + 1) +
                              " to " + std::to_string(status.newest) + " (another run came between)",
                          motion_of(status));
    }
    reader_.begin(origin, status.acknowledged);
    return origin;
}

asio::awaitable<core::Status> Session::release() {
    const std::array<std::int32_t, 8> none{};
    const auto released = co_await give(Opcode::release, none);
    begun_ = false;
    if (!released) co_return tl::unexpected(released.error());
    co_return core::Status{};
}

}  // namespace cmm::drivers::controller
