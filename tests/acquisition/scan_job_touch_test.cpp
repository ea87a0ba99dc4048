// SPDX-License-Identifier: Apache-2.0
// Sections measured by single touches. On the simulator: tests/system/touch_test.cpp.
#include <functional>

#include "acquisition/run_results.hpp"
#include "acquisition/touch_way.hpp"
#include "tests/acquisition/outline_contact.hpp"
#include "tests/acquisition/scan_job_fixture.hpp"

namespace cmm::acquisition {
namespace {

struct TouchJobTest : ScanJobTest {
    TouchJobTest() {
        machine.caps.scans_paths = machine.caps.appends_paths = false;
        machine.contact = part;
    }
    /// Nothing is there at these places of the first section.
    void miss(std::size_t first, std::size_t count) {
        machine.contact = [this, first, count](const drivers::PathPoint& at) -> std::optional<Eigen::Vector3d> {
            for (std::size_t i = first; i < first + count; ++i) {
                const auto& place = job.plan.paths[0].points.at(i);
                if ((at.centre_mm - place.centre_mm).cross(place.normal).norm() < 1e-6) return std::nullopt;
            }
            return part(at);
        };
    }
    std::vector<core::Sample> samples() const { return Journal::read(file).value()->samples().value(); }
    /// Every place of the plan has its contact, in order, but for those left out.
    void expect_places(const std::vector<std::size_t>& left_out_of_first = {}) const {
        const auto kept = samples();
        std::size_t at = 0;
        for (const auto& path : job.plan.paths) {
            for (std::size_t i = 0; i < path.points.size(); ++i) {
                const bool out = path.section == 0 && std::find(left_out_of_first.begin(), left_out_of_first.end(),
                                                                i) != left_out_of_first.end();
                if (out) continue;
                ASSERT_LT(at, kept.size());
                const auto& place = path.points[i];
                const Eigen::Vector3d centre = core::centre_mm(kept[at], test_lsb_mm);
                EXPECT_LT((centre - place.centre_mm).cross(place.normal).norm(), 1e-3)
                    << "section " << path.section << " place " << i;
                EXPECT_TRUE(core::of_section(kept[at]));
                ++at;
            }
        }
        EXPECT_EQ(at, kept.size());
    }

    OutlineContact part{job};
};

TEST_F(TouchJobTest, AMachineThatOnlyTouchesMeasuresEverySection) {
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_TRUE(ran.outcome.result.complete);
    EXPECT_EQ(ran.outcome.result.verdict(), Decision::accept);
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_EQ(machine.count("touch"), points());
    expect_places();
    for (std::size_t i = 0; i < 2; ++i) {
        const auto& section = ran.outcome.result.sections.at(i);
        ASSERT_TRUE(section.has_contour()) << section.why;
        for (const auto& point : section.fit->contour)
            EXPECT_LT(std::abs(distance_to_outline(point.position_mm, part.outlines.at(i))), 0.02);
    }
    EXPECT_TRUE(results_of_run(file, nullptr)->complete);
}

TEST_F(TouchJobTest, OnRequestAlsoWhereTheMachineCouldScan) {
    machine.caps.scans_paths = true;
    touch = true;
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_EQ(machine.count("touch"), points());
}

TEST_F(TouchJobTest, AMachineThatKnowsNothingOfTheStylusIsNotAskedToQualifyIt) {
    machine.status.qualified = true;
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("qualify"), 0U);
}

TEST_F(TouchJobTest, AMachineThatCannotIsRefusedBeforeAnythingMoves) {
    machine.caps.touches = false;
    for (const bool scans : {false, true}) {
        machine.caps.scans_paths = scans;
        touch = scans;
        const auto ran = run();
        ASSERT_TRUE(ran.outcome.error);
        EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_refused);
        EXPECT_TRUE(holds(ran.outcome.error->text(), scans ? "leave --touch out" : "can neither scan"))
            << ran.outcome.error->text();
        for (const auto* call : {"begin_run", "home", "move", "touch"})
            EXPECT_EQ(machine.count(call), 0U) << call;
        forget();
    }
}

TEST_F(TouchJobTest, NoWayLeadsThroughThePart) {
    Eigen::Vector3d from = Eigen::Vector3d::Zero();
    double least_mm = 10.0;
    const auto look = [&](const Eigen::Vector3d& to) {
        for (double share = 0.0; share <= 1.0; share += 0.1) {
            const Eigen::Vector3d at = from + share * (to - from);
            if (at.z() < 41.0) least_mm = std::min(least_mm, part.gap_mm(at));
        }
    };
    std::size_t moves = 0;
    machine.on_call = [&](const std::string&) {
        for (; moves < machine.moves.size(); ++moves)
            look(machine.moves[moves]);
        from = machine.status.position_mm;
    };
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_GT(moves, points());
    EXPECT_GT(least_mm, 0.5);
}

TEST_F(TouchJobTest, APlaceWithoutContactIsAGapAndTheJobGoesOn) {
    miss(10, 2);
    std::string told;
    with_job = [&](ScanJob& scan) { scan.on_notice([&](const std::string& notice) { told += notice; }); };
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_TRUE(ran.outcome.result.complete);
    EXPECT_TRUE(holds(told, "mm): 2 places without contact")) << told;
    EXPECT_EQ(machine.count("clear_fault"), 2U);
    expect_places({10, 11});
}

TEST_F(TouchJobTest, ManyPlacesInARowWithoutContactEndIt) {
    miss(10, 20);
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_no_contact);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "6 places in a row")) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("touch"), 16U);
    EXPECT_EQ(durable(), 10U);
    // Back where the last touch began.
    EXPECT_GT(part.gap_mm(machine.status.position_mm), 0.5);
}

TEST_F(TouchJobTest, ASampleThatWaitsInTheControllerIsTakenUpOnce) {
    miss(5, 2);
    machine.cut_touch = 30;
    ASSERT_TRUE(run().outcome.error);
    EXPECT_EQ(durable(), 27U);
    forget();
    machine.cut_touch = 0;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("touch"), points() - 30U);
    EXPECT_TRUE(ran.outcome.result.complete);
    expect_places({5, 6});
}

TEST_F(TouchJobTest, AStopRequestEndsItAndTheRunGoesOn) {
    with_job = [this](ScanJob& scan) {
        machine.on_call = [this, &scan](const std::string& call) {
            if (call == "touch" && machine.count("touch") == 40) scan.request_stop();
        };
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::cancelled) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("touch"), 40U);
    EXPECT_EQ(machine.calls.back(), "end_run");
    forget();
    with_job = {};
    machine.on_call = {};
    const auto rest = run(true);
    ASSERT_FALSE(rest.outcome.error) << rest.outcome.error->text();
    EXPECT_EQ(machine.count("touch"), points() - 40U);
    expect_places();
}

TEST_F(TouchJobTest, AnOpenDoorIsWaitedFor) {
    machine.fail_at = "touch";
    machine.fail_number = 20;
    machine.fail_code = ErrorCode::machine_door;
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_NE(ran.find(EventKind::hold), nullptr);
    EXPECT_EQ(machine.count("touch"), points() + 1U);
    expect_places();
}

TEST_F(TouchJobTest, ARunGoesOnByTouchesWithoutBeingAskedAgain) {
    machine.caps.scans_paths = true;
    touch = true;
    machine.cut_touch = 30;
    ASSERT_TRUE(run().outcome.error);
    forget();
    machine.cut_touch = 0;
    touch = false;
    std::string told;
    with_job = [&](ScanJob& scan) { scan.on_notice([&](const std::string& notice) { told += notice; }); };
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_TRUE(holds(told, "by single touches, as the run began")) << told;
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_EQ(machine.count("touch"), points() - 30U);
    expect_places();
}

TEST_F(TouchJobTest, AScannedRunIsNotGoneOnWithByTouches) {
    machine.caps.scans_paths = machine.caps.appends_paths = true;
    machine.cut_after = 30;
    ASSERT_TRUE(run().outcome.error);
    const std::size_t before = durable();
    machine.cut_after = 0;
    for (const bool asked : {true, false}) {
        forget();
        touch = asked;
        machine.caps.scans_paths = asked;
        const auto refused = run(true);
        ASSERT_TRUE(refused.outcome.error);
        EXPECT_EQ(refused.outcome.error->code, asked ? ErrorCode::usage : ErrorCode::machine_refused);
        EXPECT_TRUE(holds(refused.outcome.error->text(), "was begun by scanning")) << refused.outcome.error->text();
        EXPECT_TRUE(holds(refused.outcome.error->text(), asked ? "leave --touch out" : "another machine"));
        for (const auto* call : {"begin_run", "clear_fault", "home", "move", "touch", "scan"})
            EXPECT_EQ(machine.count(call), 0U) << call;
        EXPECT_EQ(durable(), before);
    }
    forget();
    machine.caps.scans_paths = true;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(durable(), points());
}

TEST_F(TouchJobTest, ATouchedRunNeedsAMachineThatTouches) {
    machine.cut_touch = 30;
    ASSERT_TRUE(run().outcome.error);
    forget();
    machine.cut_touch = 0;
    machine.caps.scans_paths = true;
    machine.caps.touches = false;
    const auto ran = run(true);
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_refused);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "was begun by single touches")) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("begin_run"), 0U);
}

struct UnknownTouchJobTest : TouchJobTest {
    UnknownTouchJobTest() {
        text = unknown_part_text();
        machine.contact = part;
    }
    void expect_blade(const ScanOutcome& outcome) const {
        EXPECT_TRUE(outcome.result.complete);
        ASSERT_EQ(outcome.result.sections.size(), 2U);
        for (std::size_t i = 0; i < 2; ++i) {
            const auto& section = outcome.result.sections[i];
            ASSERT_TRUE(section.has_contour()) << section.why;
            for (const auto& point : section.fit->contour)
                EXPECT_LT(std::abs(distance_to_outline(point.position_mm, part.outlines.at(i))), 0.02);
        }
    }
};

TEST_F(UnknownTouchJobTest, FindsThePartAndGoesRoundIt) {
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_EQ(machine.count("clear_fault"), 0U);
    expect_blade(ran.outcome);
}

TEST_F(UnknownTouchJobTest, IsResumedInTheMiddleOfASection) {
    machine.cut_touch = 60;
    ASSERT_TRUE(run().outcome.error);
    const std::size_t before = durable();
    forget();
    machine.cut_touch = 0;
    const auto ran = run(true);
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_EQ(durable(), before + 1 + machine.count("touch"));
    expect_blade(ran.outcome);
}

TEST_F(UnknownTouchJobTest, ASurfaceThatEndsIsSaidSo) {
    std::size_t touches = 0;
    machine.on_call = [&](const std::string& call) { touches += call == "touch" ? 1 : 0; };
    machine.contact = [&](const drivers::PathPoint& at) {
        return touches < 60 ? part(at) : std::optional<Eigen::Vector3d>();
    };
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_no_contact);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "the surface was lost")) << ran.outcome.error->text();
    EXPECT_EQ(machine.count("touch"), 62U);
}

}  // namespace
}  // namespace cmm::acquisition
