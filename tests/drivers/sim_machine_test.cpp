// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "machine_fixtures.hpp"

namespace cmm::drivers {
namespace {

using test::centre_radius_mm;
using test::MachineRig;
using test::RecordingSink;

class SimMachine : public test::SimulatedMachineTest {
  protected:
    void bring_up(double speed) {
        ASSERT_NO_FATAL_FAILURE(start(speed));
        SimulatedMachineTest::bring_up(test::settings_for(simulator_->url()));
    }
};

TEST_F(SimMachine, ScansAKnownPathCompletely) {
    bring_up(0.0);
    const auto points = test::circle_path(centre_radius_mm, 20.0, 5000, 50.0);
    RecordingSink sink;
    const auto scanned = scan_points(points, sink, {.id = 7, .approach_mm = 2.0, .search_mm = 1.0, .retract_mm = 2.0});
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(scanned->points_passed, 5000U);
    EXPECT_EQ(scanned->first_sequence, 1U);
    EXPECT_EQ(scanned->last_sequence, 5000U);
    EXPECT_TRUE(sink.out_of_order.empty());
    ASSERT_EQ(sink.kept.size(), 5000U);
    EXPECT_EQ(sink.kept.front().path, 7U);
    expect_on_circle(sink);
    const auto state = rig_->run(machine().state());
    ASSERT_TRUE(state);
    EXPECT_EQ(state->acknowledged_sequence, 5000U);
    EXPECT_EQ(state->fifo_level, 0U);
    EXPECT_FALSE(state->in_motion);
}

TEST_F(SimMachine, TouchGivesTheContactAndItsSample) {
    bring_up(0.0);
    RecordingSink sink;
    const auto contact = rig_->run(machine().touch({10.0, 0.0, 20.0}, 20.0, 2.0, sink));
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_NEAR(contact->x(), centre_radius_mm, 0.005);
    EXPECT_NEAR(contact->z(), 20.0, 0.001);
    ASSERT_EQ(sink.kept.size(), 1U);
    EXPECT_NE(sink.kept[0].flags & core::sample_flag::touch, 0);
    const auto nothing = rig_->run(machine().touch({40.0, 0.0, 30.0}, 20.0, 2.0, sink));
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().code, core::ErrorCode::machine_no_contact);
    EXPECT_EQ(nothing.error().motion, core::Motion::stopped);
}

TEST_F(SimMachine, ALongPathOverrunsNothingAndArrivesOnce) {
    bring_up(0.0);
    constexpr std::size_t count = 60'000;  // many times the controller's FIFO and path store
    const auto points = test::circle_path(centre_radius_mm, 20.0, count, 300.0);
    RecordingSink sink;
    const auto scanned = scan_points(points, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(scanned->points_passed, count);
    EXPECT_EQ(scanned->last_sequence, count);
    EXPECT_EQ(sink.delivered(), count);
    EXPECT_TRUE(sink.out_of_order.empty());
    expect_on_circle(sink);
}

/// Walks round an unknown body: each next point continues the circle through what was measured so far, one step ahead.
class AroundUnknown final : public PathSource {
  public:
    explicit AroundUnknown(const RecordingSink& sink) : sink_(sink) {}
    std::size_t next(std::span<PathPoint> room, bool& last) override {
        if (given_ > sink_.delivered() + 4) return 0;
        const double angle = 0.05 * static_cast<double>(given_);
        room[0].normal = {std::cos(angle), std::sin(angle), 0.0};
        room[0].centre_mm = centre_radius_mm * room[0].normal + Eigen::Vector3d(0.0, 0.0, 20.0);
        room[0].speed_mm_s = 20.0;
        last = ++given_ == 150;
        return 1;
    }

  private:
    const RecordingSink& sink_;
    std::size_t given_ = 0;
};

TEST_F(SimMachine, AnUnknownPathIsExtendedWhileItIsScanned) {
    bring_up(0.0);
    RecordingSink sink;
    AroundUnknown source(sink);
    const auto scanned = rig_->run(machine().scan(ScanPath{.id = 2}, source, sink));
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(sink.delivered(), 150U);
    EXPECT_TRUE(sink.out_of_order.empty());
    expect_on_circle(sink);
}

TEST_F(SimMachine, AStopDuringAScanBrakesAndKeepsTheSamples) {
    bring_up(10.0);
    stop_during_a_scan();
    test::expect_done(rig_->run(machine().clear_fault()));
}

TEST_F(SimMachine, AHostThatFallsSilentIsStoppedByTheWatchdogAndResumed) {
    bring_up(10.0);  // the watchdog counts wall time all the same
    const auto points = test::circle_path(centre_radius_mm, 20.0, 4000, 2.0);
    PointList source(points);
    RecordingSink sink;
    sink.immediately_durable = false;  // the journal kept nothing
    const auto scanning = rig_->start(machine().scan(ScanPath{}, source, sink));
    ASSERT_TRUE(rig_->wait([&] { return sink.delivered() >= 50; }));
    // From here nobody turns this host's loop any more: as good as dead. Its successor looks on until the machine
    // stands.
    MachineRig successor(test::settings_for(simulator_->url()), 2);
    Machine& second = *successor.machine;
    ASSERT_TRUE(successor.run(second.connect()));
    const auto stopped = [&] {
        const auto state = successor.run(second.state());
        return state && state->state == MachineState::stopped;
    };
    ASSERT_TRUE(successor.wait(stopped));
    const RunOrigin origin{
        .boot_id = successor.run(second.connect())->boot_id, .sequence_shift = 0, .last_sequence = 0};
    const auto resumed = successor.run(second.begin_run(origin));
    ASSERT_TRUE(resumed) << resumed.error().text();
    test::expect_done(successor.run(second.clear_fault()));
    RecordingSink rest;
    const auto drained = successor.run(second.drain(rest));
    ASSERT_TRUE(drained) << drained.error().text();
    const auto state = successor.run(second.state());
    ASSERT_TRUE(state);
    EXPECT_EQ(rest.last, state->newest_sequence);
    EXPECT_GE(rest.last, sink.last);
    EXPECT_TRUE(rest.out_of_order.empty());
    EXPECT_EQ(state->fifo_level, 0U);
    // The first host wakes up and finds its motion ended.
    ASSERT_TRUE(rig_->wait([&] { return scanning->done(); }));
    ASSERT_FALSE(*scanning->result);
    EXPECT_NE((*scanning->result).error().motion, core::Motion::not_concerned);
}

}  // namespace
}  // namespace cmm::drivers
