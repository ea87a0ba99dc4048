// SPDX-License-Identifier: Apache-2.0
#include "sim/controller.hpp"

#include <gtest/gtest.h>

#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {
namespace {

using State = MachineState;

TEST(Controller, OneOwnerAtATime) {
    Rig rig;
    expect_failed(rig.send(opcode::claim, {}, 0), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::home), ResultCode::not_owner);
    EXPECT_EQ(rig.send(opcode::claim).state, CommandState::done);
    EXPECT_EQ(rig.controller.owner(), 7U);
    EXPECT_EQ(rig.send(opcode::claim).state, CommandState::done) << "the same owner may claim again";
    expect_failed(rig.send(opcode::claim, {}, 8), ResultCode::not_owner);
    expect_failed(rig.send(opcode::home, {}, 8), ResultCode::not_owner);
    rig.run_ms(600);
    expect_failed(rig.send(opcode::claim, {}, 8), ResultCode::not_owner);
    rig.clock.advance(std::chrono::milliseconds(501));
    EXPECT_EQ(rig.send(opcode::claim, {}, 8).state, CommandState::done) << "the old owner's watchdog has run out";
    EXPECT_EQ(rig.send(opcode::release, {}, 8).state, CommandState::done);
    EXPECT_EQ(rig.controller.owner(), 0U);
}

TEST(Controller, ASequenceIsExecutedOnce) {
    Rig rig;
    rig.send(opcode::claim);
    const Command home{2, opcode::home, 7, {}};
    rig.controller.command(home);
    rig.finish();
    ASSERT_EQ(rig.controller.state(), State::idle);
    rig.controller.command(home);
    EXPECT_EQ(rig.controller.state(), State::idle) << "the same block again must not home again";
    EXPECT_EQ(rig.controller.command_status().state, CommandState::done);
}

TEST(Controller, UnknownOpcodes) {
    Rig rig;
    rig.send(opcode::claim);
    expect_failed(rig.send(0), ResultCode::unknown_opcode);
    expect_failed(rig.send(11), ResultCode::unknown_opcode);
}

TEST(Controller, MotionsNeedHomeAndQualification) {
    Rig rig;
    rig.send(opcode::claim);
    expect_failed(rig.send(opcode::move, {0, 0, 0, 1000}), ResultCode::refused);
    expect_failed(rig.send(opcode::qualify, {10000}), ResultCode::refused);
    rig.finish(opcode::home);
    EXPECT_EQ(rig.controller.flags() & 1, 1);
    EXPECT_EQ(rig.finish(opcode::move, {500000, 0, 0, 400000}).result, ResultCode::ok);
    expect_failed(rig.send(opcode::touch, {0, 0, 0, 1000, 0}), ResultCode::refused);
    expect_failed(rig.send(opcode::scan, {1, 1000, 1000, 1000}), ResultCode::refused);
    expect_failed(rig.finish(opcode::qualify, {20000}), ResultCode::bad_argument);
    const CommandStatus qualified = rig.finish(opcode::qualify, {10050});
    EXPECT_EQ(qualified.state, CommandState::done);
    EXPECT_EQ(qualified.values[0], 10000);
    EXPECT_EQ(rig.controller.flags(), 1 | 2 | 16);
}

TEST(Controller, MoveTakesTheTimeOfItsTrapezoid) {
    Rig rig;
    rig.prepare();
    const std::int64_t start_us = rig.controller.time_us();
    EXPECT_EQ(rig.finish(opcode::move, {500000, 500000, 0, 50000}).result, ResultCode::ok);  // 50 mm at 50 mm/s
    const double took_s = static_cast<double>(rig.controller.time_us() - start_us) * 1e-6;
    EXPECT_NEAR(took_s, 50.0 / 50.0 + 50.0 / 1500.0, 0.002);
    EXPECT_NEAR((rig.controller.position_mm() - Eigen::Vector3d(50, 50, 0)).norm(), 0.0, 1e-9);
}

TEST(Controller, MachineTimeScalesWithSpeed) {
    ControllerOptions options = bar_options();
    options.speed = 10.0;
    Rig rig(options);
    rig.prepare();
    const std::int64_t start_us = rig.controller.time_us();
    const auto host = rig.clock.now();
    rig.finish(opcode::move, {500000, 500000, 0, 50000});
    const double host_s = core::seconds(rig.clock.now() - host);
    EXPECT_NEAR(static_cast<double>(rig.controller.time_us() - start_us) * 1e-6, 10.0 * host_s, 1e-5);
    EXPECT_NEAR(host_s, 0.1033, 0.002);
}

TEST(Controller, BadArgumentsAndLimits) {
    Rig rig;
    rig.prepare();
    expect_failed(rig.send(opcode::move, {0, 0, 0, 0}), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::touch, {0, 0, 0, 1000, -1}), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::move, {5000001, 0, 0, 1000}), ResultCode::travel_limit);
    expect_failed(rig.send(opcode::move, {0, 0, -1000001, 1000}), ResultCode::travel_limit);
    expect_failed(rig.send(opcode::touch, {0, 0, 7000001, 1000, 0}), ResultCode::travel_limit);
    expect_failed(rig.send(opcode::stop, {3}), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::path_begin, {0}), ResultCode::bad_argument);
    expect_failed(rig.send(opcode::path_begin, {65536}), ResultCode::bad_argument);
    EXPECT_EQ(rig.controller.state(), State::idle);
}

TEST(Controller, ASecondMotionIsRefusedNotQueued) {
    Rig rig;
    rig.prepare();
    rig.send(opcode::move, {500000, 1000000, 0, 10000});
    const Eigen::Vector3d before = rig.controller.position_mm();
    expect_failed(rig.send(opcode::move, {500000, 0, 0, 10000}), ResultCode::busy);
    expect_failed(rig.send(opcode::release), ResultCode::busy);
    expect_failed(rig.send(opcode::path_begin, {1}), ResultCode::busy);
    rig.run_ms(1000);
    EXPECT_EQ(rig.controller.state(), State::moving);
    EXPECT_GT(rig.controller.position_mm().y(), before.y() + 5.0);
}

TEST(Controller, AMoveIntoThePartIsACollision) {
    Rig rig;
    rig.prepare();
    expect_failed(rig.finish(opcode::move, {-500000, 0, 0, 100000}), ResultCode::collision);
    EXPECT_EQ(rig.controller.state(), State::fault);
    EXPECT_EQ(rig.controller.fault(), ResultCode::collision);
    EXPECT_NEAR(rig.controller.position_mm().x(), circle_mm, 1e-5);
    expect_failed(rig.send(opcode::move, {500000, 0, 0, 1000}), ResultCode::refused);
    EXPECT_EQ(rig.send(opcode::clear_fault).state, CommandState::done);
    EXPECT_EQ(rig.controller.fault(), ResultCode::ok);
    EXPECT_EQ(rig.finish(opcode::move, {500000, 0, 0, 100000}).result, ResultCode::ok) << "away from the part";
}

TEST(Controller, TouchGivesTheBallCentreAndBacksOff) {
    Rig rig;
    rig.prepare();
    const CommandStatus touched = rig.finish(opcode::touch, {0, 0, 0, 10000, 20000});
    EXPECT_EQ(touched.result, ResultCode::ok);
    EXPECT_NEAR(touched.values[0], 110000, 1);
    EXPECT_EQ(touched.values[1], 0);
    EXPECT_NEAR(rig.controller.position_mm().x(), circle_mm + 2.0, 1e-5);
    ASSERT_EQ(rig.samples().size(), 1U);
    EXPECT_EQ(rig.samples()[0].quality, quality::touch);
    EXPECT_EQ(rig.samples()[0].counts[0], touched.values[0]);
    EXPECT_EQ(rig.truth[0].index, -1);
    expect_failed(rig.finish(opcode::touch, {500000, 500000, 0, 100000, 0}), ResultCode::no_contact);
    EXPECT_EQ(rig.controller.state(), State::idle);
    EXPECT_NEAR(rig.controller.position_mm().y(), 50.0, 1e-6);
}

TEST(Controller, ControlledStopBrakesWithinSpeedOverAcceleration) {
    Rig rig;
    rig.prepare();
    rig.send(opcode::move, {500000, 4000000, 0, 300000});
    rig.run_ms(500);
    const double before = rig.controller.position_mm().y();
    rig.controller.stop(StopKind::controlled);
    EXPECT_EQ(rig.controller.state(), State::moving) << "still braking";
    rig.run_ms(199);
    EXPECT_EQ(rig.controller.state(), State::moving);
    rig.run_ms(2);  // 300 / 1500 s
    EXPECT_EQ(rig.controller.state(), State::stopped);
    EXPECT_EQ(rig.controller.fault(), ResultCode::stopped);
    expect_failed(rig.controller.command_status(), ResultCode::stopped);
    EXPECT_NEAR(rig.controller.position_mm().y() - before, 300.0 * 300.0 / (2 * 1500.0), 1e-3);
    expect_failed(rig.send(opcode::move, {0, 0, 0, 1000}), ResultCode::refused);
    EXPECT_EQ(rig.send(opcode::clear_fault).state, CommandState::done);
    EXPECT_EQ(rig.controller.state(), State::idle);
}

TEST(Controller, AStopAtRestIsRememberedToo) {
    Rig rig;
    rig.prepare();
    rig.controller.stop(StopKind::controlled);
    EXPECT_EQ(rig.controller.state(), State::stopped);
    expect_failed(rig.send(opcode::move, {500000, 10000, 0, 1000}), ResultCode::refused);
}

TEST(Controller, EmergencyStopsDeadAndStaysPressed) {
    Rig rig;
    rig.prepare();
    rig.send(opcode::move, {500000, 4000000, 0, 300000});
    rig.run_ms(500);
    const Eigen::Vector3d before = rig.controller.position_mm();
    rig.controller.stop(StopKind::emergency);
    EXPECT_EQ(rig.controller.state(), State::emergency);
    expect_failed(rig.controller.command_status(), ResultCode::emergency);
    rig.run_ms(10);
    EXPECT_EQ(rig.controller.position_mm(), before);
    rig.controller.stop(StopKind::controlled);
    EXPECT_EQ(rig.controller.state(), State::emergency) << "a lesser stop does not lift it";
    expect_failed(rig.send(opcode::clear_fault), ResultCode::refused);
    expect_failed(rig.send(opcode::home), ResultCode::refused);
    EXPECT_EQ(rig.send(opcode::clear_fault, {1}).state, CommandState::done);
    EXPECT_EQ(rig.controller.flags() & 1, 1) << "homed stays";
    EXPECT_EQ(rig.finish(opcode::move, {500000, 0, 0, 300000}).result, ResultCode::ok);
}

TEST(Controller, StopCommandLeavesTheReasonInTheFault) {
    Rig rig;
    rig.prepare();
    rig.send(opcode::move, {500000, 4000000, 0, 300000});
    rig.run_ms(100);
    EXPECT_EQ(rig.send(opcode::stop, {1}, 99).state, CommandState::done) << "from anybody";
    rig.run_ms(300);
    EXPECT_EQ(rig.controller.state(), State::stopped);
    EXPECT_EQ(rig.controller.fault(), ResultCode::stopped);
    EXPECT_EQ(rig.controller.command_status().state, CommandState::done) << "that of the stop";
}

TEST(Controller, SilenceOfTheHostStopsAMotionInWallTime) {
    for (const double speed : {1.0, 20.0}) {
        ControllerOptions options = bar_options();
        options.speed = speed;
        Rig rig(options);
        rig.prepare();
        rig.send(opcode::move, {500000, 4000000, 0, 10000});
        rig.run_ms(50);
        for (int i = 0; i < 499; ++i) {
            rig.clock.advance(std::chrono::milliseconds(1));
            rig.controller.feed_watchdog(rig.watchdog);  // the same value is no change
            rig.controller.step();
        }
        EXPECT_EQ(rig.controller.owner(), 7U) << speed;
        for (int i = 0; i < 200; ++i) {
            rig.clock.advance(std::chrono::milliseconds(1));
            rig.controller.step();
        }
        EXPECT_EQ(rig.controller.state(), State::stopped);
        EXPECT_EQ(rig.controller.fault(), ResultCode::watchdog);
        expect_failed(rig.controller.command_status(), ResultCode::watchdog);
        EXPECT_EQ(rig.controller.owner(), 0U);
        expect_failed(rig.send(opcode::clear_fault), ResultCode::not_owner);
        EXPECT_EQ(rig.send(opcode::claim).state, CommandState::done);
        EXPECT_EQ(rig.send(opcode::clear_fault).state, CommandState::done);
    }
}

TEST(Controller, RestNeedsNoWatchdog) {
    Rig rig;
    rig.prepare();
    rig.clock.advance(std::chrono::seconds(10));
    rig.controller.step();
    EXPECT_EQ(rig.controller.state(), State::idle);
    EXPECT_EQ(rig.controller.owner(), 7U);
}

TEST(Controller, HeartbeatChangesWithin20Milliseconds) {
    Rig rig;
    std::uint16_t last = rig.controller.heartbeat();
    for (int i = 0; i < 10; ++i) {
        rig.run_ms(20);
        EXPECT_NE(rig.controller.heartbeat(), last);
        last = rig.controller.heartbeat();
    }
}

TEST(Controller, HomeGoesUpBeforeItGoesAcross) {
    Rig rig;
    rig.prepare();
    rig.finish(opcode::move, {500000, 0, 0, 400000});
    rig.send(opcode::home);
    rig.run_ms(500);
    EXPECT_NEAR(rig.controller.position_mm().x(), 50.0, 1e-9);
    EXPECT_GT(rig.controller.position_mm().z(), 50.0);
    EXPECT_EQ(rig.controller.state(), State::homing);
    rig.finish();
    EXPECT_EQ(rig.controller.position_mm(), rig.controller.options().machine.home_mm);
}

}  // namespace
}  // namespace cmm::sim::test
