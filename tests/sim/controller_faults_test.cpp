// SPDX-License-Identifier: Apache-2.0
// What a fault plan does to the controller, seen as a host sees it.
#include <gtest/gtest.h>

#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {
namespace {

using State = MachineState;

/// A scan with some samples behind it.
class ControllerFaults : public testing::Test {
  protected:
    void SetUp() override {
        rig_.prepare();
        rig_.begin_scan(3, arc_path(400, 0.005, 10.0));
        while (rig_.controller.fifo().newest() < 50 && rig_.controller.state() == State::scanning)
            rig_.run_ms(1);
        ASSERT_GE(rig_.controller.fifo().newest(), 50U);
    }
    void expect_ended(ResultCode result, State state) {
        expect_failed(rig_.finish(), result);
        EXPECT_EQ(rig_.controller.state(), state);
        EXPECT_EQ(rig_.controller.fault(), result);
        EXPECT_TRUE(rig_.controller.at_rest());
    }
    Rig rig_;
};

TEST_F(ControllerFaults, ADoorStopsTheMachineAndKeepsItAtRestUntilItIsClosed) {
    rig_.controller.break_down(ResultCode::door);
    expect_ended(ResultCode::door, State::stopped);
    expect_failed(rig_.send(opcode::clear_fault), ResultCode::door);
    rig_.controller.restore(ResultCode::temperature);
    expect_failed(rig_.send(opcode::clear_fault), ResultCode::door);
    rig_.controller.restore(ResultCode::door);
    EXPECT_EQ(rig_.send(opcode::clear_fault).state, CommandState::done);
    EXPECT_EQ(rig_.controller.state(), State::idle);
}

TEST_F(ControllerFaults, APersonReleasesTheEmergencyStop) {
    rig_.controller.break_down(ResultCode::emergency);
    expect_ended(ResultCode::emergency, State::emergency);
    expect_failed(rig_.send(opcode::clear_fault), ResultCode::refused);
    rig_.controller.restore(ResultCode::emergency);
    EXPECT_EQ(rig_.controller.state(), State::emergency);
    EXPECT_EQ(rig_.send(opcode::clear_fault).state, CommandState::done);
}

TEST_F(ControllerFaults, ACollisionStopsDead) {
    const Eigen::Vector3d before = rig_.controller.position_mm();
    rig_.controller.break_down(ResultCode::collision);
    expect_ended(ResultCode::collision, State::fault);
    EXPECT_EQ(rig_.controller.position_mm(), before);
}

TEST_F(ControllerFaults, ALostPositionHasToBeHomedAgain) {
    rig_.controller.break_down(ResultCode::position_lost);
    expect_ended(ResultCode::position_lost, State::fault);
    EXPECT_EQ(rig_.send(opcode::clear_fault).state, CommandState::done);
    expect_failed(rig_.send(opcode::move, {500000, 0, 0, 1000}), ResultCode::refused);
    EXPECT_EQ(rig_.controller.flags() & 1, 0);
    EXPECT_NE(rig_.controller.flags() & 4, 0);
    rig_.controller.restore(ResultCode::position_lost);
    EXPECT_EQ(rig_.controller.flags() & 4, 0) << "led clear by hand";
}

TEST_F(ControllerFaults, AnOverflowEndsThePathAndIsSaid) {
    rig_.controller.break_down(ResultCode::overflow);
    expect_ended(ResultCode::overflow, State::fault);
    EXPECT_TRUE(rig_.controller.overflowed());
}

TEST_F(ControllerFaults, ARestartForgetsEverythingButThePosition) {
    const Eigen::Vector3d before = rig_.controller.position_mm();
    rig_.controller.restart(99);
    EXPECT_EQ(rig_.controller.position_mm(), before);
    EXPECT_EQ(rig_.controller.options().boot_id, 99);
    EXPECT_EQ(rig_.controller.fifo().newest(), 0U);
    EXPECT_EQ(rig_.controller.owner(), 0U);
    EXPECT_EQ(rig_.controller.state(), State::idle);
    EXPECT_EQ(rig_.controller.flags() & 3, 0) << "neither homed nor qualified";
    EXPECT_EQ(rig_.controller.path().id(), 0);
}

TEST_F(ControllerFaults, ALongLiftOffLosesTheSurfaceAShortOneIsFlagged) {
    rig_.controller.lift_off(2, 0.3);
    rig_.run_ms(50);
    int flagged = 0;
    for (const FifoSample& sample : rig_.samples())
        flagged += (sample.quality & quality::no_contact) != 0 ? 1 : 0;
    EXPECT_EQ(flagged, 2);
    EXPECT_EQ(rig_.controller.state(), State::scanning);
    rig_.controller.lift_off(1000, 0.3);
    expect_failed(rig_.finish(), ResultCode::no_contact);
    EXPECT_EQ(rig_.controller.state(), State::idle);
}

TEST_F(ControllerFaults, DirtLiftsSoManyPoints) {
    const auto radius = [](const FifoSample& sample) { return 1e-4 * std::hypot(sample.counts[0], sample.counts[1]); };
    rig_.controller.soil(4, 0.1);
    rig_.run_ms(50);
    int dirty = 0;
    for (const FifoSample& sample : rig_.samples())
        dirty += std::abs(radius(sample) - (circle_mm + 0.1)) < 0.01 ? 1 : 0;
    EXPECT_EQ(dirty, 4);
}

TEST_F(ControllerFaults, AClockThatJumpsBackEndsABlockNotTheOrder) {
    rig_.controller.jump_clock(-0.5);
    rig_.run_ms(50);
    const auto samples = rig_.samples();
    int back = 0;
    for (std::size_t k = 1; k < samples.size(); ++k)
        back += samples[k].time_us < samples[k - 1].time_us ? 1 : 0;
    EXPECT_EQ(back, 1);
}

TEST_F(ControllerFaults, ARefusalIsForSoManyRequests) {
    rig_.controller.refuse_next(4, 2);
    EXPECT_EQ(rig_.controller.take_refusal(), 4);
    EXPECT_EQ(rig_.controller.take_refusal(), 4);
    EXPECT_EQ(rig_.controller.take_refusal(), 0);
}

}  // namespace
}  // namespace cmm::sim::test
