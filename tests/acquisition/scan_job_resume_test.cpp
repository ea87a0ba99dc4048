// SPDX-License-Identifier: Apache-2.0
/// Runs that go on where they were interrupted.
#include "acquisition/run_results.hpp"
#include "acquisition/scan_job.hpp"
#include "tests/acquisition/scan_job_fixture.hpp"

namespace cmm::acquisition {
namespace {

TEST_F(ScanJobTest, AResumedRunFetchesTheRestAndSkipsWhatIsFinished) {
    const std::size_t first = job.plan.paths[0].points.size();
    ASSERT_NO_FATAL_FAILURE(broken_run(first + 25, 5));
    const Eigen::Vector3d left_at = machine.status.position_mm;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    ASSERT_TRUE(machine.resumed_from);
    EXPECT_EQ(machine.resumed_from->last_sequence, first + 25);
    EXPECT_EQ(machine.resumed_from->boot_id, 77U);
    EXPECT_EQ(machine.count("home"), 0U);
    EXPECT_EQ(machine.count("qualify"), 0U);
    EXPECT_EQ(machine.count("scan"), 1U);
    EXPECT_EQ(machine.delivered, points());  // every point once
    // The probe leaves the part along the normal before it goes anywhere.
    ASSERT_FALSE(machine.moves.empty());
    const auto normal = job.plan.paths[1].points[29].normal;
    EXPECT_NEAR((machine.moves[0] - left_at - job.part.scan.approach_mm * normal).norm(), 0.0, 0.02);

    const auto& result = ran.outcome.result;
    EXPECT_TRUE(result.complete);
    EXPECT_EQ(result.verdict(), Decision::accept);
    EXPECT_EQ(result.run_id, "run-1");
    ASSERT_EQ(result.sections.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i)
        EXPECT_EQ(result.sections[i].points.size(), job.plan.paths[i].points.size());
    EXPECT_EQ(ran.outcome.latency.closed.count, 1U);
    EXPECT_EQ(ran.outcome.latency.decided.count, 1U);  // the restored section was not measured now
    EXPECT_NE(ran.find(EventKind::resume), nullptr);
    EXPECT_GT(ran.events.front().seq, 1U);
    EXPECT_TRUE(results_of_run(file, nullptr)->complete);
}

TEST_F(ScanJobTest, ASectionWhoseLastPointsAreFetchedByTheResumeIsFinished) {
    // Cut off after the last sample of the first section, before the path was marked as finished.
    machine.fail_at = "retract";
    ASSERT_TRUE(run().outcome.error);
    forget();
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("scan"), 1U);
    EXPECT_TRUE(ran.outcome.result.complete);
    const auto again = results_of_run(file, nullptr);
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_TRUE(again->complete);
    EXPECT_EQ(again->verdict(), Decision::accept);
}

TEST_F(ScanJobTest, AnotherPartFileIsRefusedBeforeAnythingMoves) {
    ASSERT_NO_FATAL_FAILURE(broken_run(30, 1));
    text = session_part_text("0.9");
    const auto ran = run(true);
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::config_invalid);
    EXPECT_TRUE(holds(ran.outcome.error->message, file));
    for (const auto* call : {"begin_run", "home", "move", "scan", "drain", "end_run"})
        EXPECT_EQ(machine.count(call), 0U) << call;
    EXPECT_EQ(durable(), 30U);
}

TEST_F(ScanJobTest, AMachineOfAnotherCountSizeDoesNotGoOnWithTheRun) {
    ASSERT_NO_FATAL_FAILURE(broken_run(40, 0));
    machine.caps.lsb_mm = 2.0 * test_lsb_mm;
    const auto ran = run(true);
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::config_invalid);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "counts of 100.000 nm, this machine has counts of 200.000 nm"))
        << ran.outcome.error->text();
    EXPECT_EQ(machine.count("scan"), 0U);
}

}  // namespace
}  // namespace cmm::acquisition
