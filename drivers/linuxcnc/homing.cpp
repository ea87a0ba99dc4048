// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/homing.hpp"

#include <algorithm>
#include <boost/asio/use_awaitable.hpp>
#include <limits>
#include <utility>

#include "drivers/refusal.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

namespace asio = boost::asio;
using core::ErrorCode;
using core::Motion;
using core::Status;
using Eigen::Vector3d;

constexpr double look_for_homing_every_ms = 50.0;
constexpr double settled_ms = 500.0;  // flags of an earlier homing stay set until a joint's turn comes
constexpr double not_homing_mm = 0.02;

asio::awaitable<Status> wait_for_homing(RshSession& session, Motions& motions, double patience_s) {
    Vector3d last_mm = Vector3d::Constant(std::numeric_limits<double>::max());
    double moved_ms = session.now_ms();
    double unhomed_ms = moved_ms;
    for (;;) {
        Messages messages;
        auto going_on = co_await motions.finish(messages);  // in manual mode the interpreter is always idle
        if (!going_on) co_return going_on;
        const auto position = co_await session.position_mm("joint_pos");
        if (!position) co_return tl::unexpected(position.error());
        const auto homed = co_await session.homed();
        if (!homed) co_return tl::unexpected(homed.error());
        const double now_ms = session.now_ms();
        if (!((*position - last_mm).norm() <= not_homing_mm)) {
            last_mm = *position;
            moved_ms = now_ms;
        }
        if (!*homed) unhomed_ms = now_ms;
        if (now_ms - std::max(moved_ms, unhomed_ms) >= settled_ms) co_return going_on;
        if (!*homed && now_ms - moved_ms >= 1e3 * patience_s) {
            core::Error error{ErrorCode::machine_refused,
                              "homing stands still and not every joint is homed: HOME_SEQUENCE must be given for each "
                              "joint in LinuxCNC's ini file, and `joints` in [linuxcnc] be as many",
                              {},
                              Motion::unknown};
            error = co_await motions.abandon(std::move(error));
            co_return tl::unexpected(std::move(error));
        }
        co_await session.pause(look_for_homing_every_ms);
    }
}

}  // namespace

asio::awaitable<Status> switch_on(RshSession& session, bool may_reset_estop) {
    const auto now = co_await session.look();
    if (!now) co_return tl::unexpected(now.error());
    if (now->estop && !may_reset_estop) {
        co_return core::fail(ErrorCode::machine_emergency,
                             "LinuxCNC is in emergency stop, as it is after its start: take it back at LinuxCNC (F1), "
                             "or allow homing to do so by reset_estop = true in [linuxcnc]",
                             Motion::stopped);
    }
    Status done;
    if (now->estop) done = co_await session.set_switch("estop", false, ErrorCode::machine_emergency);
    if (done && !now->machine_on) done = co_await session.set_switch("machine", true, ErrorCode::machine_refused);
    co_return done;
}

asio::awaitable<Status> home_all_joints(RshSession& session, Motions& motions, const LinuxcncSettings& settings) {
    if (!session.in_control()) co_return refuse("no run has been begun on this machine");
    if (session.stop_asked() != 0) co_return refuse("the machine was stopped; the stop has to be cleared first");
    const auto now = co_await session.look();
    if (!now) co_return tl::unexpected(now.error());
    if (!now->idle) co_return core::fail(ErrorCode::machine_busy, "LinuxCNC runs a program", Motion::may_be_moving);
    auto ready = co_await switch_on(session, settings.reset_estop);
    if (ready) ready = co_await session.set_mode("MANUAL");
    // Joints are homed one by one; once they are, LinuxCNC jogs axes, and would refuse.
    if (ready) ready = co_await session.set_switch("teleop_enable", false, ErrorCode::machine_refused);
    Messages old;
    if (ready) ready = co_await session.collect(old);
    if (ready) ready = co_await session.set("home -1");
    if (!ready) co_return ready;
    co_return co_await wait_for_homing(session, motions, settings.home_patience_s);
}

}  // namespace cmm::drivers::linuxcnc
