// SPDX-License-Identifier: Apache-2.0
// The probe is moved back after contact where none should be. On the simulator: tests/system/retract_test.cpp.
#include "tests/acquisition/scan_job_fixture.hpp"

namespace cmm::acquisition {
namespace {

struct RetractTest : ScanJobTest {
    /// The probe is bent too far at a point of the second section.
    void bend() {
        machine.cut_after = job.plan.paths[0].points.size() + 25;
        machine.cut_keeps = 1;
        machine.cut_code = ErrorCode::machine_deflection;
    }
    const drivers::PathPoint& bent_at() const { return job.plan.paths[1].points[25]; }
};

TEST_F(RetractTest, AfterOverDeflectionTheProbeLeavesThePartAlongItsNormal) {
    bend();
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_deflection);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the probe was moved back 1.000 mm")) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("clear_fault"), 1U);
    const Eigen::Vector3d clear = bent_at().centre_mm + job.part.scan.approach_mm * bent_at().normal;
    EXPECT_NEAR((machine.moves.back() - clear).norm(), 0.0, 0.02);
    EXPECT_GE(machine.stops, 1U);
    EXPECT_EQ(machine.calls.back(), "end_run");
    ASSERT_NE(ran.find(EventKind::machine_fault), nullptr);
    EXPECT_TRUE(holds(ran.find(EventKind::machine_fault)->payload, "moved back"));
}

TEST_F(RetractTest, AfterACollisionItGoesBackTheWayItCame) {
    machine.fail_at = "move";
    machine.fail_number = 2;
    machine.fail_code = ErrorCode::machine_fault;
    machine.fail_in_fault = true;
    Eigen::Vector3d struck_at = Eigen::Vector3d::Zero();
    machine.on_call = [&](const std::string& call) {
        if (call == "clear_fault") struck_at = machine.status.position_mm;
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_fault);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the probe was moved back")) << ran.outcome.error->text();
    // A collision on the way from the first point of the route to the second.
    ASSERT_EQ(machine.moves.size(), 2U);
    const Eigen::Vector3d back = machine.moves[0] - struck_at;
    ASSERT_GT(back.norm(), 0.01);
    const double far_mm = std::min(back.norm(), job.part.scan.clearance_mm);
    EXPECT_NEAR((machine.moves[1] - struck_at - far_mm * back.normalized()).norm(), 0.0, 1e-6);
    EXPECT_EQ(machine.count("scan"), 0U);
}

TEST_F(RetractTest, NeverWithoutReferences) {
    bend();
    machine.on_scanned = [this](std::size_t scanned) {
        if (scanned == machine.cut_after) machine.status.homed = false;
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the probe was not moved back: the machine has no references"))
        << ran.outcome.error->text();
    EXPECT_EQ(machine.count("clear_fault"), 0U);
}

TEST_F(RetractTest, AMoveThatFailsIsSaid) {
    bend();
    machine.on_call = [this](const std::string& call) {
        if (call != "clear_fault") return;
        machine.fail_at = "move";
        machine.fail_number = machine.count("move") + 1;
        machine.fail_code = ErrorCode::machine_limit;
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_deflection);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the probe was not moved back: move failed"))
        << ran.outcome.error->text();
}

TEST_F(RetractTest, NotAfterAStopRequest) {
    bend();
    with_job = [this](ScanJob& scan) {
        machine.on_call = [&scan](const std::string& call) {
            if (call == "clear_fault") scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "not moved back: stopped on request")) << ran.outcome.error->text();
    const Eigen::Vector3d clear = bent_at().centre_mm + job.part.scan.approach_mm * bent_at().normal;
    EXPECT_GT((machine.moves.back() - clear).norm(), 0.1);
    EXPECT_EQ(machine.calls.back(), "end_run");
}

TEST_F(RetractTest, AStopOnTheWayBackEndsIt) {
    bend();
    std::size_t stops_before = 0;
    with_job = [&](ScanJob& scan) {
        machine.on_call = [&](const std::string& call) {
            if (call != "move" || machine.count("clear_fault") != 1) return;
            machine.status.position_mm += 0.4 * bent_at().normal;
            stops_before = machine.stops;
            scan.request_stop();
            scan.request_stop();
            machine.fail_at = "move";
            machine.fail_number = machine.count("move");
            machine.fail_code = ErrorCode::cancelled;
            machine.fail_motion = core::Motion::stopped;
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_deflection);
    EXPECT_EQ(ran.outcome.error->motion, core::Motion::stopped);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the probe was not moved back: only 0.400 of 1.000 mm, move failed"))
        << ran.outcome.error->text();
    EXPECT_GT(machine.stops, stops_before + 2);
    EXPECT_EQ(machine.status.state, drivers::MachineState::stopped);
    EXPECT_EQ(machine.calls.back(), "end_run");
    EXPECT_EQ(machine.count("clear_fault"), 1U);
}

TEST_F(RetractTest, ALinkThatBreaksOnTheWayBackLeavesNothingUnsaid) {
    bend();
    bool broken = false;
    std::size_t moves = 0;
    machine.on_call = [&](const std::string& call) {
        broken = broken || (call == "move" && machine.count("clear_fault") == 1);
        if (!broken) return;
        // Nothing comes through any more.
        machine.fail_at = call;
        machine.fail_number = machine.count(call);
        machine.fail_code = ErrorCode::transport_closed;
        machine.fail_motion = core::Motion::unknown;
        moves += call == "move" ? 1 : 0;
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_deflection);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the probe was not moved back: move failed"))
        << ran.outcome.error->text();
    // It stood when it was bent too far; what became of the way back is not known.
    EXPECT_EQ(ran.outcome.error->motion, core::Motion::unknown);
    EXPECT_GE(machine.stops, 1U);
    EXPECT_EQ(moves, 1U);
    EXPECT_EQ(durable(), machine.cut_after);
}

TEST_F(RetractTest, AMachineThatDoesNotStopOnTheWayBackIsSaidToMove) {
    bend();
    with_job = [this](ScanJob& scan) {
        machine.on_call = [this, &scan](const std::string& call) {
            if (call != "move" || machine.count("clear_fault") != 1) return;
            machine.status.in_motion = true;
            scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_deflection);
    EXPECT_EQ(ran.outcome.error->motion, core::Motion::may_be_moving);
}

}  // namespace
}  // namespace cmm::acquisition
