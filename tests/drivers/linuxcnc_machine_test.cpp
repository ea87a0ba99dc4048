// SPDX-License-Identifier: Apache-2.0
// The driver over a real socket, linuxcncrsh played by the test.
#include <gtest/gtest.h>

#include "machine_rig.hpp"
#include "scripted_linuxcnc.hpp"

namespace cmm::drivers {
namespace {

using core::ErrorCode;
using core::Motion;
using Eigen::Vector3d;
using test::MachineRig;
using test::RecordingSink;
using test::ScriptedLinuxcnc;
using State = ScriptedLinuxcnc::State;

constexpr double lsb_mm = 1e-5;
const Vector3d before_ball(80.0, 0.0, 0.0);  // the ball begins at x = 85

struct LinuxcncMachineTest : testing::Test {
    LinuxcncMachineTest() { settings.response_timeout_ms = 300.0; }
    void connect() {
        rig = std::make_unique<MachineRig>(settings);
        const auto found = rig->run(machine().connect());
        ASSERT_TRUE(found) << found.error().text();
    }
    void begin() {
        ASSERT_NO_FATAL_FAILURE(connect());
        ASSERT_TRUE(rig->run(machine().begin_run(std::nullopt)));
    }
    /// Homed, and before the ball.
    void begin_at_ball() {
        ASSERT_NO_FATAL_FAILURE(begin());
        const auto there = rig->run(machine().move(before_ball, 50.0));
        ASSERT_TRUE(there) << there.error().text();
    }
    Machine& machine() { return *rig->machine; }
    core::Result<Vector3d> touch(double x_mm = 90.0) {
        return rig->run(machine().touch({x_mm, 0.0, 0.0}, 2.0, 1.0, sink));
    }
    core::Status move(double x_mm) { return rig->run(machine().move({x_mm, 0.0, 0.0}, 50.0)); }
    void expect_ready() {
        const auto again = move(70.0);
        EXPECT_TRUE(again) << again.error().text();
    }

    ScriptedLinuxcnc linuxcnc;
    LinkSettings settings = test::settings_for(linuxcnc.url());
    std::unique_ptr<MachineRig> rig;
    RecordingSink sink;
};

TEST_F(LinuxcncMachineTest, ConnectingChangesNothing) {
    ASSERT_NO_FATAL_FAILURE(connect());
    const auto state = rig->run(machine().state());
    ASSERT_TRUE(state) << state.error().text();
    EXPECT_EQ(state->state, MachineState::idle);
    EXPECT_TRUE(state->homed);
    EXPECT_EQ(linuxcnc.heard("set"), 2);  // echo and verbose: of this connection
    EXPECT_EQ(machine().link_stats().errors(), 0U);
    const auto unasked = move(10.0);
    ASSERT_FALSE(unasked);
    EXPECT_EQ(unasked.error().code, ErrorCode::machine_refused);
}

TEST_F(LinuxcncMachineTest, AWrongPasswordIsNamed) {
    linuxcnc.change([](State& s) { s.password = "other"; });
    rig = std::make_unique<MachineRig>(settings);
    const auto found = rig->run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::protocol_mismatch);
    EXPECT_NE(found.error().message.find("connect_password"), std::string::npos) << found.error().message;

    linuxcnc.change([](State& s) { s.password = "EMC"; });
    settings.linuxcnc.enable_password = "wrong";
    ASSERT_NO_FATAL_FAILURE(connect());
    const auto begun = rig->run(machine().begin_run(std::nullopt));
    ASSERT_FALSE(begun);
    EXPECT_NE(begun.error().message.find("enable_password"), std::string::npos) << begun.error().message;
}

TEST_F(LinuxcncMachineTest, ATouchGivesTheContactAndBacksOff) {
    linuxcnc.change([](State& s) { s.offset_mm = {3.0, -4.0, 5.0}; });  // of G54: somebody's work piece
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    for (std::uint64_t k = 1; k <= 3; ++k) {
        const auto contact = touch();
        ASSERT_TRUE(contact) << contact.error().text();
        EXPECT_NEAR(contact->x(), 85.0, 2e-6);
        EXPECT_NEAR(linuxcnc.state().position_mm.x(), 84.0, 1e-5);
        ASSERT_EQ(sink.kept.size(), k);
        EXPECT_EQ(sink.kept.back().sequence, k);
        EXPECT_EQ(sink.kept.back().flags, core::sample_flag::touch);
        EXPECT_NEAR(core::centre_mm(sink.kept.back(), lsb_mm).x(), 85.0, 1e-5);
    }
    EXPECT_EQ(rig->run(machine().state())->newest_sequence, 3U);
    EXPECT_EQ(linuxcnc.heard("set mdi G21 "), 1);  // asked for once, looked up every time
    const auto resumed = rig->run(machine().begin_run(RunOrigin{0, 0, 7}));
    ASSERT_TRUE(resumed);
    sink.last = 7;
    ASSERT_TRUE(touch());
    EXPECT_EQ(sink.kept.back().sequence, 8U);
    EXPECT_TRUE(rig->run(machine().end_run()));
    EXPECT_EQ(linuxcnc.heard("set enable off"), 1);
}

TEST_F(LinuxcncMachineTest, TheLatchDelayIsTakenBackAlongTheApproach) {
    settings.linuxcnc.latch_delay_us = 500.0;
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    const auto contact = touch();
    ASSERT_TRUE(contact);
    EXPECT_NEAR(contact->x(), 85.0 - 0.001, 2e-6);
}

TEST_F(LinuxcncMachineTest, AnInchMachineIsReadInMillimetres) {
    linuxcnc.change([](State& s) {
        s.units = "INCH";
        s.unit_mm = 25.4;
        s.offset_mm = {25.4, 0.0, 0.0};
    });
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    const auto contact = touch();
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_NEAR(contact->x(), 85.0, 1e-4);
    EXPECT_NEAR(rig->run(machine().state())->position_mm.x(), 84.0, 1e-4);
}

TEST_F(LinuxcncMachineTest, AMissIsNoContactWhateverTheOldFlagSays) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    ASSERT_TRUE(touch());
    const auto missed = touch(84.5);
    ASSERT_FALSE(missed);
    EXPECT_EQ(missed.error().code, ErrorCode::machine_no_contact) << missed.error().text();
    EXPECT_EQ(missed.error().motion, Motion::stopped);
    EXPECT_EQ(sink.kept.size(), 1U);
    EXPECT_NEAR(linuxcnc.state().position_mm.x(), 84.0, 1e-5);  // where the touch began
    expect_ready();
}

TEST_F(LinuxcncMachineTest, AReportThatAnotherInterfaceHasReadIsAskedForAgain) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    linuxcnc.change([](State& s) { s.stolen_reports = 2; });
    const auto contact = touch();
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_EQ(linuxcnc.heard("set mdi #<_cmmlive>"), 1);
    EXPECT_EQ(sink.kept.size(), 1U);
}

TEST_F(LinuxcncMachineTest, ATouchIsNotBegunInContact) {
    ASSERT_NO_FATAL_FAILURE(begin());
    linuxcnc.change([](State& s) { s.position_mm = {86.0, 0.0, 0.0}; });
    const auto refused = touch();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::machine_refused);
    EXPECT_EQ(linuxcnc.heard("set mdi #<_cmmlive>"), 0);
}

TEST_F(LinuxcncMachineTest, AContactBesideTheApproachIsNotBelieved) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    linuxcnc.change([](State& s) { s.contact_shift_mm = {0.0, 2.0, 0.0}; });
    const auto odd = touch();
    ASSERT_FALSE(odd);
    EXPECT_EQ(odd.error().code, ErrorCode::protocol_invalid) << odd.error().text();
    EXPECT_TRUE(sink.kept.empty());
}

TEST_F(LinuxcncMachineTest, ARotatedCoordinateSystemIsRefused) {
    linuxcnc.change([](State& s) { s.rotation_deg = 30.0; });
    ASSERT_NO_FATAL_FAILURE(begin());
    const auto refused = move(50.0);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("rotated"), std::string::npos) << refused.error().message;
    linuxcnc.change([](State& s) { s.rotation_deg = 0.0; });
    expect_ready();
}

TEST_F(LinuxcncMachineTest, LimitsAreNamed) {
    ASSERT_NO_FATAL_FAILURE(begin());
    const auto beyond = move(900.0);
    ASSERT_FALSE(beyond);
    EXPECT_EQ(beyond.error().code, ErrorCode::machine_limit) << beyond.error().text();
    EXPECT_EQ(beyond.error().motion, Motion::stopped);
    expect_ready();

    settings.linuxcnc.limit_min_mm = Vector3d(-10.0, -10.0, -10.0);
    settings.linuxcnc.limit_max_mm = Vector3d(100.0, 100.0, 100.0);
    settings.linuxcnc.max_speed_mm_s = 60.0;
    ASSERT_NO_FATAL_FAILURE(begin());
    const int lines = linuxcnc.heard("set mdi");
    const auto known = move(101.0);
    ASSERT_FALSE(known);
    EXPECT_EQ(known.error().code, ErrorCode::machine_limit);
    EXPECT_EQ(rig->run(machine().move({1.0, 0.0, 0.0}, 61.0)).error().code, ErrorCode::machine_refused);
    EXPECT_EQ(linuxcnc.heard("set mdi"), lines);
}

TEST_F(LinuxcncMachineTest, ACollisionStopsBacksOffAndWaitsToBeCleared) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    const auto crash = move(95.0);
    ASSERT_FALSE(crash);
    EXPECT_EQ(crash.error().code, ErrorCode::machine_fault);
    EXPECT_EQ(crash.error().motion, Motion::stopped);
    EXPECT_NE(crash.error().message.find("drawn back"), std::string::npos) << crash.error().message;
    EXPECT_LT(linuxcnc.state().position_mm.x(), 85.0);
    EXPECT_EQ(rig->run(machine().state())->state, MachineState::fault);
    EXPECT_EQ(move(70.0).error().code, ErrorCode::machine_refused);
    ASSERT_TRUE(rig->run(machine().clear_fault()));
    expect_ready();
}

TEST_F(LinuxcncMachineTest, AnInterpreterThatIsIdleBeforeTheMotionBeginsIsWaitedFor) {
    linuxcnc.change([](State& s) { s.looks_before_motion = 5; });
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    for (int k = 0; k < 3; ++k) {
        const auto contact = touch();
        ASSERT_TRUE(contact) << contact.error().text();
        EXPECT_NEAR(contact->x(), 85.0, 2e-6);
        EXPECT_NEAR(linuxcnc.state().position_mm.x(), 84.0, 1e-5);
    }
    // One that never begins is given up, and taken back.
    linuxcnc.change([](State& s) { s.looks_before_motion = 1000000; });
    const int aborts = linuxcnc.heard("set abort");
    const auto never = move(70.0);
    ASSERT_FALSE(never);
    EXPECT_EQ(never.error().code, ErrorCode::machine_fault);
    EXPECT_NE(never.error().message.find("LinuxCNC did not say why"), std::string::npos) << never.error().text();
    EXPECT_EQ(never.error().motion, Motion::stopped);
    EXPECT_EQ(linuxcnc.heard("set abort"), aborts + 1);
}

TEST_F(LinuxcncMachineTest, AnEmergencyStopInMotionEndsIt) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    linuxcnc.change([](State& s) { s.estop_in_motion = true; });
    const auto ended = touch();
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, ErrorCode::machine_emergency) << ended.error().text();
    EXPECT_EQ(ended.error().motion, Motion::stopped);
    EXPECT_TRUE(sink.kept.empty());
    EXPECT_EQ(rig->run(machine().state())->state, MachineState::emergency);
    EXPECT_EQ(rig->run(machine().clear_fault()).error().code, ErrorCode::machine_emergency);
    linuxcnc.change([](State& s) { s.estop_wired_open = true; });
    EXPECT_EQ(rig->run(machine().clear_fault(true)).error().code, ErrorCode::machine_emergency);
    linuxcnc.change([](State& s) { s.estop_wired_open = false; });
    ASSERT_TRUE(rig->run(machine().clear_fault(true)));
    EXPECT_EQ(rig->run(machine().state())->state, MachineState::idle);
    expect_ready();
}

TEST_F(LinuxcncMachineTest, StopsInMotionAndAtRest) {
    ASSERT_NO_FATAL_FAILURE(begin());
    linuxcnc.change([](State& s) { s.motion_looks = 1'000'000; });
    for (const StopKind kind : {StopKind::controlled, StopKind::emergency}) {
        const auto moving = rig->start(machine().move({50.0, 0.0, 0.0}, 5.0));
        const int given = linuxcnc.heard("set mdi G53");
        ASSERT_TRUE(rig->wait([&] { return linuxcnc.heard("set mdi G53") > given; }));
        EXPECT_EQ(rig->run(machine().move({1.0, 0.0, 0.0}, 5.0)).error().code, ErrorCode::machine_busy);
        machine().stop(kind);
        machine().stop(kind);
        ASSERT_TRUE(rig->wait([&] { return moving->done(); }));
        ASSERT_FALSE(*moving->result);
        const bool emergency = kind == StopKind::emergency;
        EXPECT_EQ(moving->result->error().code, emergency ? ErrorCode::machine_emergency : ErrorCode::cancelled);
        EXPECT_EQ(moving->result->error().motion, Motion::stopped);
        EXPECT_GE(linuxcnc.heard(emergency ? "set estop on" : "set abort"), 2);
        EXPECT_FALSE(move(10.0));
        ASSERT_TRUE(rig->run(machine().clear_fault(emergency)));
    }
    EXPECT_EQ(machine().link_stats().stops, 4U);
    machine().stop(StopKind::controlled);  // nothing moves: what comes next must not begin
    EXPECT_EQ(rig->run(machine().state())->state, MachineState::stopped);
    const auto refused = move(10.0);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::machine_refused);
    ASSERT_TRUE(rig->run(machine().clear_fault()));
    linuxcnc.change([](State& s) { s.motion_looks = 3; });
    expect_ready();
}

TEST_F(LinuxcncMachineTest, ALinkThatBreaksInATouchLosesNothing) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    linuxcnc.change([](State& s) { s.hang_up_on = "get program_status"; });
    auto contact = touch();
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_EQ(sink.kept.size(), 1U);
    // The command was carried out, its acknowledgement got lost.
    linuxcnc.change([](State& s) {
        s.hang_up_on = "set mdi #<_cmmlive>";
        s.carry_out_first = true;
    });
    contact = touch();
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_EQ(sink.kept.size(), 2U);
    EXPECT_EQ(linuxcnc.heard("set mdi #<_cmmlive>"), 2);
    // The command itself got lost.
    linuxcnc.change([](State& s) {
        s.hang_up_on = "set mdi #<_cmmlive>";
        s.carry_out_first = false;
    });
    contact = touch();
    ASSERT_FALSE(contact);
    EXPECT_EQ(contact.error().code, ErrorCode::transport_closed) << contact.error().text();
    EXPECT_EQ(contact.error().motion, Motion::stopped);
    EXPECT_EQ(sink.kept.size(), 2U);
    EXPECT_EQ(machine().link_stats().reconnects, 3U);
    linuxcnc.change([](State& s) { s.hang_up_on = "set mdi G53"; });
    EXPECT_EQ(move(60.0).error().code, ErrorCode::transport_closed);
    expect_ready();
}

TEST_F(LinuxcncMachineTest, ASilentControllerIsAskedAgainOverANewConnection) {
    ASSERT_NO_FATAL_FAILURE(begin());
    linuxcnc.change([](State& s) { s.silent_on = "get estop"; });
    EXPECT_TRUE(move(50.0));
    EXPECT_EQ(machine().link_stats().timeouts, 1U);
    EXPECT_EQ(machine().link_stats().reconnects, 1U);
}

TEST_F(LinuxcncMachineTest, AControllerThatIsGoneMayStillBeMoving) {
    settings.reconnect_ms = 200.0;
    ASSERT_NO_FATAL_FAILURE(begin());
    linuxcnc.change([](State& s) { s.motion_looks = 1'000'000; });
    const auto moving = rig->start(machine().move({50.0, 0.0, 0.0}, 5.0));
    ASSERT_TRUE(rig->wait([&] { return linuxcnc.heard("set mdi G53") > 0; }));
    linuxcnc.hang_up();
    ASSERT_TRUE(rig->wait([&] { return moving->done(); }));
    ASSERT_FALSE(*moving->result);
    EXPECT_EQ(core::exit_code(moving->result->error().code), 5) << moving->result->error().text();
    EXPECT_EQ(moving->result->error().motion, Motion::may_be_moving);
    EXPECT_FALSE(rig->run(machine().state()));
}

TEST_F(LinuxcncMachineTest, HomingSwitchesOnAndWaits) {
    linuxcnc.change([](State& s) {
        s.machine = s.homed = false;
        s.estop = true;
    });
    ASSERT_NO_FATAL_FAILURE(begin());
    const auto unhomed = move(10.0);
    ASSERT_FALSE(unhomed);
    EXPECT_EQ(unhomed.error().code, ErrorCode::machine_emergency);
    const auto pressed = rig->run(machine().home());
    ASSERT_FALSE(pressed);
    EXPECT_EQ(pressed.error().code, ErrorCode::machine_emergency);
    EXPECT_NE(pressed.error().message.find("reset_estop"), std::string::npos) << pressed.error().message;

    settings.linuxcnc.reset_estop = true;
    ASSERT_NO_FATAL_FAILURE(begin());
    const auto homed = rig->run(machine().home());
    ASSERT_TRUE(homed) << homed.error().text();
    EXPECT_EQ(linuxcnc.heard("set home -1"), 1);
    expect_ready();
}

TEST_F(LinuxcncMachineTest, HomingThatStandsStillFails) {
    linuxcnc.change([](State& s) {
        s.homed = false;
        s.never_homes = true;
    });
    settings.linuxcnc.home_patience_s = 0.3;
    ASSERT_NO_FATAL_FAILURE(begin());
    EXPECT_EQ(move(10.0).error().code, ErrorCode::machine_refused);
    const auto failed = rig->run(machine().home());
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::machine_refused);
    EXPECT_NE(failed.error().message.find("HOME_SEQUENCE"), std::string::npos) << failed.error().message;
    EXPECT_EQ(linuxcnc.heard("set abort"), 1);
}

TEST_F(LinuxcncMachineTest, WhatItCannotDoIsRefused) {
    ASSERT_NO_FATAL_FAILURE(begin());
    const auto path = test::circle_path(5.0, 0.0, 8, 1.0);
    PointList source(path);
    const auto scanned = rig->run(machine().scan(ScanPath{}, source, sink));
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::machine_refused);
    EXPECT_NE(scanned.error().message.find("cannot scan along a path"), std::string::npos);
    const auto qualified = rig->run(machine().qualify(1.0));
    ASSERT_FALSE(qualified);
    EXPECT_NE(qualified.error().message.find("reference sphere"), std::string::npos);
    EXPECT_EQ(rig->run(machine().drain(sink)), 0U);
}

TEST_F(LinuxcncMachineTest, ASinkThatFailsStillGetsTheProbeOffThePart) {
    ASSERT_NO_FATAL_FAILURE(begin_at_ball());
    sink.fail_at = 1;
    const auto full = touch();
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().code, ErrorCode::journal_full);
    EXPECT_NEAR(linuxcnc.state().position_mm.x(), 84.0, 1e-5);
}

TEST_F(LinuxcncMachineTest, AnotherClientsProgramIsNotInterrupted) {
    ASSERT_NO_FATAL_FAILURE(begin());
    linuxcnc.change([](State& s) { s.motion_looks = 1'000'000; });
    const auto moving = rig->start(machine().move({50.0, 0.0, 0.0}, 5.0));
    ASSERT_TRUE(rig->wait([&] { return linuxcnc.heard("set mdi G53") > 0; }));
    MachineRig second(settings, 2);
    ASSERT_TRUE(second.run(second.machine->connect()));
    const auto seen = second.run(second.machine->state());
    ASSERT_TRUE(seen);
    EXPECT_EQ(seen->state, MachineState::moving);
    ASSERT_TRUE(second.run(second.machine->begin_run(std::nullopt)));
    const auto refused = second.run(second.machine->move({1.0, 0.0, 0.0}, 5.0));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::machine_busy);
    // The first one learns who has the control now.
    linuxcnc.change([](State& s) { s.motion_looks = 3; });
    second.machine->stop(StopKind::controlled);
    ASSERT_TRUE(rig->wait([&] { return moving->done(); }));
    EXPECT_FALSE(*moving->result);
}

}  // namespace
}  // namespace cmm::drivers
