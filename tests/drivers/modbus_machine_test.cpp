// SPDX-License-Identifier: Apache-2.0
// The Modbus driver against a scripted controller over a real socket: the way things go when all is well, and refusals.
#include "drivers/machine.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>
#include <thread>

#include "machine_rig.hpp"
#include "scripted_controller.hpp"

namespace cmm::drivers {
namespace {

using core::ErrorCode;
using test::MachineRig;
using test::RecordingSink;
using test::ScriptedController;

class ModbusMachineTest : public testing::Test {
  protected:
    Machine& machine() { return *rig_.machine; }
    void connect() {
        const auto found = rig_.run(machine().connect());
        ASSERT_TRUE(found) << found.error().text();
    }
    void begin() {
        connect();
        const auto origin = rig_.run(machine().begin_run(std::nullopt));
        ASSERT_TRUE(origin) << origin.error().text();
    }
    core::Result<ScanResult> scan(std::size_t points, RecordingSink& sink, std::uint16_t id = 1) {
        const auto path = test::circle_path(20.0, 5.0, points, 10.0);
        PointList source(path);
        return rig_.run(machine().scan(ScanPath{.id = id}, source, sink));
    }

    ScriptedController controller_;
    MachineRig rig_{test::settings_for(controller_.url())};
};

TEST_F(ModbusMachineTest, ReadsTheIdentity) {
    const auto found = rig_.run(machine().connect());
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(found->model, "scripted");
    EXPECT_EQ(found->serial, "A1");
    EXPECT_EQ(found->firmware, "2.7");
    EXPECT_EQ(found->boot_id, 77U);
    EXPECT_DOUBLE_EQ(found->lsb_mm, 1e-4);
    EXPECT_DOUBLE_EQ(found->sample_rate_hz, 1000.0);
    EXPECT_EQ(found->path_window, 10U);
    EXPECT_DOUBLE_EQ(found->limit_min_mm.y(), -500.0);
    EXPECT_DOUBLE_EQ(found->max_speed_mm_s, 400.0);
    EXPECT_TRUE(found->scans_paths && found->touches && found->gives_deflection && found->appends_paths);
    EXPECT_EQ(controller_.executed(1), 0) << "connecting must change nothing";
}

TEST_F(ModbusMachineTest, RefusesAForeignDevice) {
    controller_.set_register(0, 0x1234);
    const auto found = rig_.run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::protocol_mismatch);
    EXPECT_NE(found.error().text().find("CMM1"), std::string::npos) << found.error().text();
}

TEST_F(ModbusMachineTest, RefusesAnotherMapVersion) {
    controller_.set_register(2, 9);
    const auto found = rig_.run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::protocol_mismatch);
    EXPECT_NE(found.error().text().find("version 9"), std::string::npos) << found.error().text();
}

TEST_F(ModbusMachineTest, RefusesADamagedIdentity) {
    controller_.set_register(22, 1, false);
    const auto found = rig_.run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::protocol_invalid);
}

TEST_F(ModbusMachineTest, RefusesImpossibleIdentityValues) {
    controller_.set_register(24, 11);
    const auto found = rig_.run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, ErrorCode::protocol_invalid);
    EXPECT_NE(found.error().text().find("path window"), std::string::npos) << found.error().text();
}

TEST_F(ModbusMachineTest, NothingMovesBeforeARunIsBegun) {
    connect();
    const auto homed = rig_.run(machine().home());
    ASSERT_FALSE(homed);
    EXPECT_EQ(homed.error().code, ErrorCode::machine_refused);
    EXPECT_EQ(controller_.executed(3), 0);
}

TEST_F(ModbusMachineTest, HomesQualifiesMovesAndTouches) {
    begin();
    EXPECT_TRUE(rig_.run(machine().home()));
    EXPECT_TRUE(rig_.run(machine().qualify(1.0)));
    EXPECT_TRUE(rig_.run(machine().move({1.0, 2.0, 3.0}, 50.0)));
    RecordingSink sink;
    const auto contact = rig_.run(machine().touch({10.0, -20.0, 30.5}, 5.0, 1.0, sink));
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_NEAR((*contact - Eigen::Vector3d(10.0, -20.0, 30.5)).norm(), 0.0, 1e-9);
    ASSERT_EQ(sink.kept.size(), 1U);
    EXPECT_EQ(sink.kept[0].flags, core::sample_flag::touch);
    EXPECT_EQ(sink.kept[0].counts[1], -200'000);
    const auto state = rig_.run(machine().state());
    ASSERT_TRUE(state);
    EXPECT_TRUE(state->homed && state->qualified && state->owned_by_us);
    EXPECT_FALSE(state->in_motion);
    EXPECT_TRUE(rig_.run(machine().end_run()));
    const auto released = rig_.run(machine().state());
    ASSERT_TRUE(released);
    EXPECT_FALSE(released->owned);
}

TEST_F(ModbusMachineTest, ScansDeliversOnceAndAcknowledgesAll) {
    begin();
    RecordingSink sink;
    const auto scanned = scan(333, sink, 9);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(scanned->points_passed, 333U);
    EXPECT_EQ(sink.kept.size(), 333U);
    EXPECT_TRUE(sink.out_of_order.empty());
    EXPECT_EQ(sink.kept[100].path, 9U);
    // The scripted controller gives the expected centre back, rounded to counts.
    const auto path = test::circle_path(20.0, 5.0, 333, 10.0);
    EXPECT_NEAR((core::centre_mm(sink.kept[100], 1e-4) - path[100].centre_mm).norm(), 0.0, 1e-4);
    EXPECT_EQ(sink.kept[101].machine_time_us - sink.kept[100].machine_time_us, 1000);
    EXPECT_EQ(controller_.acknowledged(), 333U);
    EXPECT_EQ(controller_.executed(7), 1);
    EXPECT_GE(sink.hastened, 1);
}

TEST_F(ModbusMachineTest, SequencesOfASecondPathGoOn) {
    begin();
    RecordingSink sink;
    ASSERT_TRUE(scan(50, sink, 1));
    const auto second = scan(60, sink, 2);
    ASSERT_TRUE(second) << second.error().text();
    EXPECT_EQ(second->first_sequence, 51U);
    EXPECT_EQ(second->last_sequence, 110U);
    EXPECT_TRUE(sink.out_of_order.empty());
}

TEST_F(ModbusMachineTest, AcknowledgesOnlyWhatIsDurable) {
    begin();
    RecordingSink sink;
    sink.immediately_durable = false;
    std::uint32_t most_acknowledged_early = 0;
    sink.on_delivery = [&] { most_acknowledged_early = std::max(most_acknowledged_early, controller_.acknowledged()); };
    const auto scanned = scan(200, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(most_acknowledged_early, 0U) << "nothing was durable before the flush";
    EXPECT_EQ(controller_.acknowledged(), 200U);
}

TEST_F(ModbusMachineTest, ASecondOperationIsRefused) {
    begin();
    controller_.motions_take(1'000'000);
    const auto homing = rig_.start(machine().home());
    ASSERT_TRUE(rig_.wait([&] { return controller_.executed(3) == 1; }));
    const auto second = rig_.run(machine().move({0.0, 0.0, 0.0}, 10.0));
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::machine_busy);
    EXPECT_EQ(second.error().motion, core::Motion::may_be_moving);
    EXPECT_EQ(controller_.executed(5), 0);
    const auto state = rig_.run(machine().state());  // may be asked in between
    ASSERT_TRUE(state) << state.error().text();
    EXPECT_TRUE(state->in_motion);
    EXPECT_EQ(state->state, MachineState::homing);
    machine().stop(StopKind::controlled);
    ASSERT_TRUE(rig_.wait([&] { return homing->done(); }));
    EXPECT_EQ((*homing->result).error().code, ErrorCode::cancelled);
    EXPECT_EQ((*homing->result).error().motion, core::Motion::stopped);
}

TEST_F(ModbusMachineTest, AnEmergencyStopIsClearedByAPersonOnly) {
    begin();
    controller_.motions_take(1'000'000);
    const auto homing = rig_.start(machine().home());
    ASSERT_TRUE(rig_.wait([&] { return controller_.executed(3) == 1; }));
    machine().stop(StopKind::emergency);
    ASSERT_TRUE(rig_.wait([&] { return homing->done(); }));
    EXPECT_EQ((*homing->result).error().code, ErrorCode::machine_emergency);
    EXPECT_EQ(controller_.stop_value(), 2U);
    const auto refused = rig_.run(machine().clear_fault(false));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::machine_emergency) << "why it is refused, not that";
    EXPECT_EQ(rig_.run(machine().move({1.0, 2.0, 3.0}, 10.0)).error().code, ErrorCode::machine_emergency);
    EXPECT_TRUE(rig_.run(machine().clear_fault(true)));
}

TEST_F(ModbusMachineTest, AnotherOwnerIsNamed) {
    begin();
    rig_.machine.reset();
    MachineRig second(test::settings_for(controller_.url()), 2);
    ASSERT_TRUE(second.run(second.machine->connect()));
    const auto refused = second.run(second.machine->begin_run(std::nullopt));
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::machine_refused);
    EXPECT_NE(refused.error().text().find("owns"), std::string::npos) << refused.error().text();
}

TEST_F(ModbusMachineTest, RefusesTargetsOutsideTheLimits) {
    begin();
    const auto moved = rig_.run(machine().move({0.0, 900.0, 0.0}, 10.0));
    ASSERT_FALSE(moved);
    EXPECT_EQ(moved.error().code, ErrorCode::machine_limit);
    EXPECT_NE(moved.error().text().find("y = 900.000"), std::string::npos) << moved.error().text();
    EXPECT_FALSE(rig_.run(machine().move({0.0, 0.0, 0.0}, 1e6)));
    EXPECT_FALSE(rig_.run(machine().move({0.0, std::nan(""), 0.0}, 10.0)));
    EXPECT_FALSE(rig_.run(machine().qualify(0.0)));
    EXPECT_EQ(controller_.executed(5), 0);
}

TEST_F(ModbusMachineTest, AnOverflowEndsThePathAfterItsSamplesWereDelivered) {
    begin();
    RecordingSink sink;
    sink.on_delivery = [&] {
        if (sink.delivered() >= 30 && controller_.register_at(64) == 4) controller_.end_motion(11, 7);
    };
    const auto scanned = scan(2000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::machine_overflow);
    EXPECT_EQ(scanned.error().motion, core::Motion::stopped);
    EXPECT_EQ(sink.delivered(), controller_.newest());
    EXPECT_EQ(controller_.acknowledged(), controller_.newest());
}

TEST_F(ModbusMachineTest, TheWatchdogsStopIsReported) {
    begin();
    RecordingSink sink;
    sink.on_delivery = [&] {
        if (sink.delivered() >= 20 && controller_.register_at(64) == 4) controller_.end_motion(10, 6);
    };
    const auto scanned = scan(2000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::machine_watchdog);
    EXPECT_EQ(scanned.error().motion, core::Motion::stopped);
    EXPECT_EQ(sink.delivered(), controller_.newest());
    // The session's way back: clear, go on.
    sink.on_delivery = {};
    EXPECT_TRUE(rig_.run(machine().clear_fault()));
    EXPECT_TRUE(scan(20, sink, 2));
}

TEST_F(ModbusMachineTest, AFailingSinkStopsTheMachine) {
    begin();
    RecordingSink sink;
    sink.fail_at = 100;
    const auto scanned = scan(2000, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::journal_full);
    EXPECT_EQ(scanned.error().motion, core::Motion::stopped);
    EXPECT_EQ(controller_.stop_value(), 1U);
    EXPECT_LT(controller_.acknowledged(), 100U);
}

TEST_F(ModbusMachineTest, APathWithoutPointsIsRefused) {
    begin();
    RecordingSink sink;
    const auto scanned = scan(0, sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::plan_invalid);
    EXPECT_EQ(controller_.executed(7), 0);
}

TEST_F(ModbusMachineTest, ABadPointInThePathIsNamed) {
    begin();
    RecordingSink sink;
    auto path = test::circle_path(20.0, 5.0, 40, 10.0);
    path[17].normal *= 2.0;
    PointList source(path);
    const auto scanned = rig_.run(machine().scan(ScanPath{}, source, sink));
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, ErrorCode::plan_invalid);
    EXPECT_NE(scanned.error().text().find("point 17"), std::string::npos) << scanned.error().text();
}

/// Invents each next point only after the sample of the one before, as a scan of an unknown part does.
class FollowingSource final : public PathSource {
  public:
    FollowingSource(const RecordingSink& sink, std::size_t total, bool notice_late)
        : sink_(sink), points_(test::circle_path(20.0, 5.0, total, 10.0)), notice_late_(notice_late) {}
    std::size_t next(std::span<PathPoint> room, bool& last) override {
        if (given_ > sink_.delivered()) return 0;
        if (given_ == points_.size()) {
            last = true;
            return 0;
        }
        room[0] = points_[given_++];
        last = !notice_late_ && given_ == points_.size();
        return 1;
    }

  private:
    const RecordingSink& sink_;
    std::vector<PathPoint> points_;
    bool notice_late_;
    std::size_t given_ = 0;
};

TEST_F(ModbusMachineTest, AnUnknownPathIsFedWhileItIsScanned) {
    begin();
    for (const bool notice_late : {false, true}) {
        RecordingSink sink;
        sink.last = controller_.newest();
        FollowingSource source(sink, 60, notice_late);
        const auto scanned = rig_.run(machine().scan(ScanPath{.id = 3}, source, sink));
        ASSERT_TRUE(scanned) << scanned.error().text();
        EXPECT_EQ(sink.delivered(), 60U);
        EXPECT_TRUE(sink.out_of_order.empty());
        // Noticed late, the end is marked by the last point once more, without a sample.
        EXPECT_EQ(scanned->points_passed, notice_late ? 61U : 60U);
    }
}

TEST_F(ModbusMachineTest, ResumeTakesUpWhereTheJournalEnds) {
    begin();
    RecordingSink first;
    first.immediately_durable = false;
    first.durable_when_hastened = false;
    const auto path = test::circle_path(20.0, 5.0, 100, 10.0);
    PointList source(path);
    const auto scanning = rig_.start(machine().scan(ScanPath{}, source, first));
    ASSERT_TRUE(rig_.wait([&] { return first.delivered() == 100; }));
    // The journal kept 40 samples, then the host died. Its successor has the same controller in front of it.
    first.durable = 40;
    ASSERT_TRUE(rig_.wait([&] { return controller_.acknowledged() == 40; }));
    const RunOrigin origin{.boot_id = 77, .sequence_shift = 0, .last_sequence = 40};
    first.durable = 100;  // lets the first operation end; the controller has heard 40 only until then
    controller_.on_request([](const test::Request&) { return test::Fault::closed; });
    ASSERT_TRUE(rig_.wait([&] { return scanning->done(); }));
    EXPECT_FALSE(*scanning->result);
    rig_.machine.reset();
    controller_.on_request({});

    MachineRig second(test::settings_for(controller_.url()), 1);  // the same seed: the same owner
    ASSERT_TRUE(second.run(second.machine->connect()));
    const auto resumed = second.run(second.machine->begin_run(origin));
    ASSERT_TRUE(resumed) << resumed.error().text();
    RecordingSink rest;
    rest.last = 40;
    const auto drained = second.run(second.machine->drain(rest));
    ASSERT_TRUE(drained) << drained.error().text();
    EXPECT_EQ(*drained, 100U);
    EXPECT_EQ(rest.kept.front().sequence, 41U);
    EXPECT_EQ(rest.kept.size(), 60U);
    EXPECT_TRUE(rest.out_of_order.empty());
    EXPECT_EQ(controller_.acknowledged(), 100U);
}

TEST_F(ModbusMachineTest, ANewRunNumbersFromOneAndGivesUpOldSamples) {
    begin();
    RecordingSink first;
    ASSERT_TRUE(scan(30, first));
    const auto origin = rig_.run(machine().begin_run(std::nullopt));
    ASSERT_TRUE(origin) << origin.error().text();
    EXPECT_EQ(origin->sequence_shift, -30);
    RecordingSink second;
    const auto scanned = scan(20, second, 2);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(second.kept.front().sequence, 1U);
    EXPECT_EQ(second.kept.size(), 20U);
}

TEST_F(ModbusMachineTest, ResumeAfterARestartOfTheControllerGoesOnInNumbers) {
    connect();
    const RunOrigin origin{.boot_id = 5, .sequence_shift = 0, .last_sequence = 500};
    const auto resumed = rig_.run(machine().begin_run(origin));
    ASSERT_TRUE(resumed) << resumed.error().text();
    EXPECT_EQ(resumed->boot_id, 77U);
    EXPECT_EQ(resumed->sequence_shift, 500);
    RecordingSink sink;
    sink.last = 500;
    ASSERT_TRUE(scan(20, sink));
    EXPECT_EQ(sink.kept.front().sequence, 501U);
    EXPECT_TRUE(sink.out_of_order.empty());
}

TEST_F(ModbusMachineTest, ResumeOfARunThatAnotherHasOverwrittenIsRefused) {
    begin();
    RecordingSink sink;
    ASSERT_TRUE(scan(30, sink));
    const RunOrigin origin{.boot_id = 77, .sequence_shift = 0, .last_sequence = 10};
    const auto resumed = rig_.run(machine().begin_run(origin));
    ASSERT_FALSE(resumed);
    EXPECT_EQ(resumed.error().code, ErrorCode::protocol_mismatch);
}

TEST_F(ModbusMachineTest, TraceAndStatisticsTellOfTheExchanges) {
    std::vector<std::string> lines;
    std::mutex mutex;
    machine().set_trace([&](std::string_view line) {
        const std::lock_guard lock(mutex);
        lines.emplace_back(line);
    });
    connect();
    machine().set_trace({});
    begin();
    ASSERT_EQ(lines.size(), 2U);
    // Read 46 registers from 0, unit 1.
    EXPECT_NE(lines[0].find("> 00 01 00 00 00 06 01 03 00 00 00 2e"), std::string::npos) << lines[0];
    EXPECT_NE(lines[1].find("< 00 01 00 00 00 5f 01 03 5c 43 4d 4d 31"), std::string::npos) << lines[1];
    const LinkStats stats = machine().link_stats();
    EXPECT_GE(stats.ok, 4U);
    EXPECT_EQ(stats.errors(), 0U);
    EXPECT_GT(stats.max_round_trip_us, 0.0);
    std::uint64_t counted = 0;
    for (const auto bucket : stats.histogram)
        counted += bucket;
    EXPECT_EQ(counted, stats.ok);
}

}  // namespace
}  // namespace cmm::drivers
