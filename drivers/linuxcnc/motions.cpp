// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/motions.hpp"

#include <algorithm>
#include <array>
#include <boost/asio/use_awaitable.hpp>
#include <cmath>
#include <utility>

#include "core/text.hpp"
#include "drivers/link_error.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

namespace asio = boost::asio;
using core::ErrorCode;
using core::Motion;
using core::Result;
using core::Status;

constexpr double motion_stop_patience_ms = 5000.0;  // a machine brakes within a second; afterwards nothing is known
constexpr double still_after_ms = 30.0;
constexpr double still_mm = 0.002;  // an encoder trembles by a count or two
constexpr double begin_patience_ms =
    3000.0;  // from "idle" until a motion begins; 1000 were too few once, on a full host
constexpr double report_patience_ms = 400.0;  // printed within a cycle of the task, unless somebody else has read it
constexpr int report_attempts = 8;
constexpr double most_rotation_deg = 1e-9;

// Millimetres, absolute, feed per minute, no cutter or tool length compensation, the first coordinate system, exact
// stops, no G92: what G38.3 and its result are given in.
constexpr std::array<std::string_view, 8> modes{"G21", "G90", "G94", "G40", "G49", "G54", "G61", "G92.2"};

}  // namespace

asio::awaitable<Status> Motions::check_state() {
    const auto now = co_await session_.look();
    if (!now) co_return tl::unexpected(now.error());
    if (now->estop) co_return tl::unexpected(emergency_error());
    if (!now->machine_on) {
        co_return core::fail(ErrorCode::machine_refused,
                             "the machine is switched off: homing switches it on, or F2 at LinuxCNC", Motion::stopped);
    }
    if (!now->idle) co_return core::fail(ErrorCode::machine_busy, "LinuxCNC runs a program", Motion::may_be_moving);
    const auto has_references = co_await session_.homed();
    if (!has_references) co_return tl::unexpected(has_references.error());
    if (*has_references) co_return Status{};
    co_return core::fail(ErrorCode::machine_refused, "the machine is not homed", Motion::stopped);
}

asio::awaitable<Status> Motions::prepare() {
    if (!session_.in_control()) {
        co_return core::fail(ErrorCode::machine_refused, "no run has been begun on this machine",
                             Motion::not_concerned);
    }
    if (session_.stop_asked() != 0) {
        co_return core::fail(ErrorCode::machine_refused, "the machine was stopped; the stop has to be cleared first",
                             Motion::stopped);
    }
    auto ready = co_await check_state();
    if (ready) ready = co_await session_.set_mode("MDI");
    Messages old;
    oldest_question_ = question_ + 1;
    if (ready) ready = co_await session_.collect(old);
    if (ready) ready = co_await set_up_interpreter();
    if (!ready) co_return ready;
    // Both come in the controller's unit, whatever unit programs have.
    const auto machine = co_await session_.position_mm("abs_cmd_pos");
    if (!machine) co_return tl::unexpected(machine.error());
    const auto program = co_await session_.position_mm("rel_cmd_pos");
    if (!program) co_return tl::unexpected(program.error());
    offset_mm_ = *machine - *program;
    co_return Status{};
}

/// A person at another user interface may have changed it at any time.
asio::awaitable<Status> Motions::set_up_interpreter() {
    std::string wanted;
    for (const auto mode : modes)
        wanted += (wanted.empty() ? "" : " ") + std::string(mode);
    for (bool told = false;; told = true) {
        const auto codes = co_await session_.get("program_codes");
        if (!codes) co_return tl::unexpected(codes.error());
        const auto present = core::split(*codes, ' ');
        const bool all = std::all_of(modes.begin(), modes.end(), [&](std::string_view mode) {
            return std::find(present.begin(), present.end(), mode) != present.end();
        });
        if (all && told) break;
        if (all && rotation_checked_) co_return Status{};
        if (told) {
            co_return core::fail(ErrorCode::machine_refused, "LinuxCNC does not take " + wanted + ", it has " + *codes,
                                 Motion::stopped);
        }
        std::string line = "mdi " + wanted;
        auto done = co_await session_.set(std::move(line));
        Messages messages;
        if (done) done = co_await finish(messages);
        if (!done) co_return done;
    }
    Messages messages;
    rotation_checked_ = false;
    const auto rotation = co_await report("#5230", messages);
    if (!rotation) co_return tl::unexpected(rotation.error());
    rotation_checked_ = !rotation->values.empty() && std::abs(rotation->values[0]) <= most_rotation_deg;
    if (rotation_checked_) co_return Status{};
    co_return core::fail(ErrorCode::machine_refused,
                         "coordinate system G54 of LinuxCNC is rotated: `G10 L2 P1 R0` takes that back",
                         Motion::stopped);
}

asio::awaitable<Status> Motions::give(std::string code) {
    if (session_.stop_asked() != 0) {
        core::Error error = co_await halt();
        co_return tl::unexpected(std::move(error));
    }
    std::string line = "mdi " + code;
    auto given = co_await session_.set(std::move(line));
    if (!given && is_transport(given.error().code)) co_return Status{};
    co_return given;
}

asio::awaitable<Status> Motions::finish(Messages& messages) {
    for (;;) {
        const auto now = co_await session_.look();
        Status told;
        if (now) told = co_await session_.collect(messages);
        if (session_.stop_asked() != 0) {
            core::Error error = co_await halt();
            co_return tl::unexpected(std::move(error));
        }
        if (!now || !told) {
            core::Error error = now ? told.error() : now.error();
            if (is_transport(error.code)) error.motion = Motion::may_be_moving;  // LinuxCNC has no watchdog of ours
            co_return tl::unexpected(std::move(error));
        }
        if (now->estop) {
            core::Error error = emergency_error();
            error.motion = co_await standstill();
            co_return tl::unexpected(std::move(error));
        }
        if (!messages.error.empty()) {
            core::Error error = co_await abandon(error_of_text(messages.error));
            co_return tl::unexpected(std::move(error));
        }
        if (!now->machine_on) {
            core::Error error{ErrorCode::machine_fault, "the machine was switched off", {}, Motion::unknown};
            error.motion = co_await standstill();
            co_return tl::unexpected(std::move(error));
        }
        if (now->idle) co_return Status{};
        co_await session_.pause(look_every_ms);
    }
}

asio::awaitable<Result<Eigen::Vector3d>> Motions::arrive(Eigen::Vector3d target_mm, Messages& messages) {
    std::optional<Eigen::Vector3d> before;
    double still_since_ms = session_.now_ms();
    for (;;) {
        auto idle = co_await finish(messages);
        if (!idle) co_return tl::unexpected(std::move(idle.error()));
        const auto position = co_await session_.position_mm("abs_cmd_pos");
        if (!position || (*position - target_mm).norm() <= arrived_mm) co_return position;
        if (!before || (*position - *before).norm() > still_mm) still_since_ms = session_.now_ms();
        if (session_.now_ms() - still_since_ms >= begin_patience_ms) co_return position;
        before = *position;
        co_await session_.pause(look_every_ms);
    }
}

asio::awaitable<Status> Motions::ask_report(std::string parameters) {
    std::string code =
        "(DEBUG," + std::string(report_word) + " " + std::to_string(++question_) + " " + parameters + ")";
    co_return co_await give(std::move(code));
}

asio::awaitable<Result<Report>> Motions::report(std::string parameters, Messages& messages) {
    for (int attempt = 0; attempt < report_attempts; ++attempt) {
        // The first one may have been asked for together with the motion.
        const double give_up_ms = session_.now_ms() + report_patience_ms;
        while (!heard(messages)) {
            // The motion before it may not even have begun (arrive).
            auto told = co_await finish(messages);
            if (!told) co_return tl::unexpected(std::move(told.error()));
            if (heard(messages) || session_.now_ms() >= give_up_ms || attempt == 0) break;
            co_await session_.pause(look_every_ms);
        }
        if (heard(messages)) co_return *std::exchange(messages.report, std::nullopt);
        const auto asked = co_await ask_report(parameters);
        if (!asked) co_return tl::unexpected(asked.error());
    }
    co_return core::fail(ErrorCode::protocol_invalid,
                         "LinuxCNC's answer does not come through: another user interface takes its messages away "
                         "(let linuxcncrsh be the only one)",
                         Motion::stopped);
}

asio::awaitable<Motion> Motions::standstill() {
    const double give_up_ms = session_.now_ms() + motion_stop_patience_ms;
    std::optional<Eigen::Vector3d> before;
    for (;;) {
        const auto position = co_await session_.position_mm("abs_act_pos");
        if (!position) co_return Motion::may_be_moving;
        if (before && (*position - *before).norm() <= still_mm) co_return Motion::stopped;
        if (session_.now_ms() >= give_up_ms) co_return Motion::may_be_moving;
        before = *position;
        co_await session_.pause(still_after_ms);
    }
}

asio::awaitable<core::Error> Motions::abandon(core::Error error) {
    const auto aborted = co_await session_.set("abort");
    error.motion = aborted ? co_await standstill() : Motion::may_be_moving;
    co_return error;
}

/// The stop is on its way already; it is told again with an answer, because one may have got lost with a link.
asio::awaitable<core::Error> Motions::halt() {
    core::Error error{ErrorCode::cancelled, "stopped on request", {}, Motion::unknown};
    const bool emergency = session_.stop_asked() == 2;
    if (emergency) error = emergency_error();
    Status told;
    if (emergency) {
        told = co_await session_.set_switch("estop", true, ErrorCode::machine_emergency);
    } else {
        told = co_await session_.set("abort");
    }
    error.motion = co_await standstill();
    if (!told && error.motion == Motion::stopped) error.motion = Motion::unknown;
    co_return error;
}

}  // namespace cmm::drivers::linuxcnc
