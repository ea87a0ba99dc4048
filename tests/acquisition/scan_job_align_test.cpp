// SPDX-License-Identifier: Apache-2.0
// A job that finds the part by six datum points. On the simulator: tests/system/six_points_test.cpp.
#include <set>
#include <utility>

#include "acquisition/datum_touches.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/part_frame.hpp"
#include "acquisition/run_results.hpp"
#include "acquisition/run_review.hpp"
#include "tests/acquisition/scan_job_fixture.hpp"
#include "tests/acquisition/six_point_blade.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// The plan's ball goes round each section in its plane; compensated in space its walls seem to lie so far off at most.
constexpr double as_planned_mm = 7e-3;

struct AlignTest : ScanJobTest {
    SessionPart placed{session_part_text() + datum_table()};
    Isometry3d truth = askew();
    std::set<std::size_t> loose;  // datum points that are not there
    double wobble_mm = 0.0;       // of the first datum, to and fro

    AlignTest() {
        text = placed.text;
        machine.contact = [this](const drivers::PathPoint& at) {
            return at.speed_mm_s == 0.0 ? touched(at) : scanned(at);
        };
    }

    /// On a flat datum, where the part stands.
    std::optional<Vector3d> touched(const drivers::PathPoint& at) {
        for (std::size_t i = 0; i < placed.plan.datum_touches.size(); ++i) {
            const auto& datum = placed.plan.datum_touches[i];
            const Vector3d place = truth * datum.centre_mm, normal = truth.linear() * datum.normal;
            const Vector3d off = at.centre_mm - place;
            if (loose.contains(i) || (off - off.dot(normal) * normal).norm() > 2.5) continue;
            double height = off.dot(normal);
            if (i == 0) height -= machine.count("touch") / 6 % 2 == 0 ? wobble_mm : -wobble_mm;
            return Vector3d(at.centre_mm - height / at.normal.dot(normal) * at.normal);
        }
        return std::nullopt;
    }
    /// The nominal blade as it stands: the planned place nearest to the one that was asked for.
    std::optional<Vector3d> scanned(const drivers::PathPoint& at) const {
        const Vector3d in_part = truth.inverse() * at.centre_mm;
        const Vector3d* nearest = nullptr;
        for (const auto& path : placed.plan.paths)
            for (const auto& point : path.points)
                if (nearest == nullptr || (point.centre_mm - in_part).norm() < (*nearest - in_part).norm())
                    nearest = &point.centre_mm;
        if ((*nearest - in_part).norm() > 0.05) return std::nullopt;
        return Vector3d(truth * *nearest);
    }
    /// The same blade where it is expected, without an alignment.
    PartResult run_straight() {
        const auto askew_text = std::exchange(text, placed.text.substr(0, placed.text.find("[alignment]")));
        const auto stands = std::exchange(truth, Isometry3d::Identity());
        const auto askew_file = std::exchange(file, folder.path("straight.cmmrun"));
        const auto straight = run();
        EXPECT_FALSE(straight.outcome.error);
        text = askew_text;
        truth = stands;
        file = askew_file;
        forget();
        return straight.outcome.result;
    }
    static void expect_same_deviations(const PartResult& a, const PartResult& b) {
        ASSERT_EQ(a.sections.size(), b.sections.size());
        for (std::size_t i = 0; i < a.sections.size(); ++i) {
            const auto &here = a.sections[i].deviation_mm, &there = b.sections[i].deviation_mm;
            ASSERT_EQ(here.size(), there.size());
            double apart_mm = 0.0;
            for (std::size_t k = 0; k < here.size(); ++k)
                apart_mm = std::max(apart_mm, std::abs(here[k].value_or(0.0) - there[k].value_or(0.0)));
            EXPECT_LT(apart_mm, 5e-4) << "section " << i;
        }
    }
    static double largest_deviation(const PartResult& result) {
        double worst = 0.0;
        for (const auto& section : result.sections)
            for (const auto& deviation : section.deviation_mm)
                if (deviation) worst = std::max(worst, std::abs(*deviation));
        return worst;
    }
};

TEST_F(AlignTest, APartThatStandsAskewIsMeasuredAsIfItStoodStraight) {
    const auto straight = run_straight();
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const auto& result = ran.outcome.result;
    ASSERT_TRUE(result.part_frame);
    const auto& frame = *result.part_frame;
    for (const auto& datum : placed.plan.datum_touches)  // counts of 0.1 um
        EXPECT_LT((frame.machine_from_part * datum.centre_mm - truth * datum.centre_mm).norm(), 2e-3);
    EXPECT_GE(frame.rounds, 2);
    EXPECT_LT(frame.largest_residual_mm(), 1e-3);
    ASSERT_EQ(result.sections.size(), 2U);
    expect_same_deviations(result, straight);
    EXPECT_EQ(result.verdict(), straight.verdict());
    // All of it in the part's frame: heights are those of the plan.
    for (const auto& section : result.sections) {
        for (const auto& point : section.points)
            EXPECT_NEAR(point.centre_mm.z(), section.z_mm, 2e-3);
        EXPECT_EQ(section.alignment.state, Alignment::State::final);
        EXPECT_EQ(section.alignment.spec.kind, AlignmentKind::six_points);
        EXPECT_TRUE(holds(section.find("profile_suction")->method, "frame of the six datum points (RPS)"));
    }
    // The machine was led in its own frame.
    const auto& last = placed.plan.paths[1].points.back();
    EXPECT_NEAR((machine.status.position_mm - truth * last.centre_mm).norm(), 0.0, 2e-3);
    ASSERT_NE(ran.find(EventKind::part_aligned), nullptr);
    EXPECT_TRUE(holds(ran.find(EventKind::part_aligned)->payload, "\"kind\":\"six_points\""));
}

TEST_F(AlignTest, TheRunFileHoldsRawPointsAndTheSameMotion) {
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    const auto journal = Journal::read(file).value();
    const auto frame = frame_from_numbers(journal->part_frame().value()).value().value();
    EXPECT_EQ(frame.machine_from_part.matrix(), ran.outcome.result.part_frame->machine_from_part.matrix());
    EXPECT_EQ(frame.covariance, ran.outcome.result.part_frame->covariance);
    std::size_t of_sections = 0;
    const auto samples = journal->samples().value();
    for (const auto& sample : samples) {
        if (!core::of_section(sample)) continue;
        ++of_sections;
        const auto there = core::centre_mm(sample, test_lsb_mm);
        EXPECT_TRUE(scanned({there, Vector3d::UnitX(), 1.0, true})) << "not where the part stands";
    }
    EXPECT_EQ(of_sections, points());
    const auto again = results_of_run(file, nullptr, {});
    ASSERT_TRUE(again) << again.error().text();
    auto of_scan = ran.outcome.result;
    EXPECT_EQ(result_json(*again), result_json(of_scan));
    EXPECT_TRUE(holds(result_json(*again), "\"part_frame\""));
    EXPECT_TRUE(holds(result_json(*again), "\"condition_length_mm\""));
    // A second frame would put the points elsewhere.
    auto open = Journal::open(file).value();
    EXPECT_FALSE(open->set_part_frame(frame_numbers(frame)));
}

TEST_F(AlignTest, ARunGoesOnInTheFrameThatWasFound) {
    machine.cut_after = placed.plan.paths[0].points.size() + 20;
    machine.cut_keeps = 3;
    const auto first = run();
    ASSERT_TRUE(first.outcome.error);
    const auto touches = machine.count("touch");
    EXPECT_GE(touches, 12U);
    forget();
    machine.cut_after = 0;
    const auto second = run(true);
    ASSERT_FALSE(second.outcome.error) << second.outcome.error->text();
    EXPECT_EQ(machine.count("touch"), 0U);
    EXPECT_LT(largest_deviation(second.outcome.result), as_planned_mm);
    ASSERT_TRUE(second.outcome.result.part_frame);
    EXPECT_EQ(second.outcome.result.sections.at(1).points.size(), placed.plan.paths[1].points.size());
}

TEST_F(AlignTest, CutOffWithinTheTouchesTheyBeginAnew) {
    machine.cut_touch = 9;
    const auto first = run();
    ASSERT_TRUE(first.outcome.error);
    EXPECT_FALSE(first.outcome.result.part_frame);
    const Vector3d stood = machine.status.position_mm;
    const auto& datum = placed.plan.datum_touches[2];
    forget();
    machine.cut_touch = 0;
    const auto second = run(true);
    ASSERT_FALSE(second.outcome.error) << second.outcome.error->text();
    // It stood on the third datum, and leaves along its normal.
    EXPECT_GT((machine.moves.front() - stood).dot(datum.normal), 0.99 * placed.part.scan.approach_mm);
    EXPECT_GE(machine.count("touch"), 12U);
    EXPECT_LT(largest_deviation(second.outcome.result), as_planned_mm);
}

TEST_F(AlignTest, AMissingDatumStopsTheRunBackAboveIt) {
    loose.insert(3);
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_no_contact);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "at datum point 4 (ball at x ")) << ran.outcome.error->text();
    EXPECT_TRUE(holds(ran.outcome.error->text(), "in round 1 of the six-point alignment"));
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_GE(machine.stops, 1U);
    const auto& datum = placed.plan.datum_touches[3];
    EXPECT_NEAR((machine.moves.back() - above(datum, placed.plan.datum_approach_mm)).norm(), 0.0, 1e-6);
    EXPECT_TRUE(Journal::read(file).value()->part_frame()->empty());
}

TEST_F(AlignTest, AnOpenDoorIsWaitedForAndTheTouchesBeginAnew) {
    machine.fail_at = "touch";
    machine.fail_number = 4;
    machine.fail_code = ErrorCode::machine_door;
    machine.fail_motion = core::Motion::stopped;
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_NE(ran.find(EventKind::hold), nullptr);
    EXPECT_GE(machine.count("touch"), 4U + 12U);
    EXPECT_LT(largest_deviation(ran.outcome.result), as_planned_mm);
}

TEST_F(AlignTest, WhatDoesNotSettleEndsTheRun) {
    wobble_mm = 0.05;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::fit_not_evaluable);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "does not settle in 10 rounds: datum point 1"))
        << ran.outcome.error->text();
    EXPECT_EQ(ran.outcome.error->motion, core::Motion::stopped);
    EXPECT_EQ(machine.count("touch"), 60U);
    EXPECT_EQ(machine.count("scan"), 0U);
    EXPECT_GE(machine.stops, 1U);
}

TEST_F(AlignTest, AMachineThatCannotTouchIsRefusedBeforeItMoves) {
    machine.caps.touches = false;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::machine_refused);
    EXPECT_TRUE(holds(ran.outcome.error->text(), "cannot be aligned by six datum points"));
    EXPECT_EQ(machine.count("move"), 0U);
}

TEST_F(AlignTest, SectionsByTouchesToo) {
    touch = true;
    // No datum lies at the height of a section.
    machine.contact = [this](const drivers::PathPoint& at) {
        const double z = (truth.inverse() * at.centre_mm).z();
        return std::abs(z - 20.0) < 1.0 || std::abs(z - 40.0) < 1.0 ? scanned(at) : touched(at);
    };
    const auto straight = run_straight();
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    EXPECT_GT(machine.count("touch"), placed.plan.paths[0].points.size() + placed.plan.paths[1].points.size());
    expect_same_deviations(ran.outcome.result, straight);
}

TEST_F(AlignTest, ASectionOutsideTheTravelAsThePartStandsIsRefused) {
    text.replace(text.find("[20, 40]"), 8, "[2, 40]");
    placed = SessionPart(text);
    machine.caps.limit_min_mm.z() = 1.9;  // room for the plan, not for a part that stands lower
    truth.translation().z() = -0.45;
    const auto ran = run();
    ASSERT_TRUE(ran.outcome.error);
    EXPECT_EQ(ran.outcome.error->code, ErrorCode::plan_invalid);
    EXPECT_TRUE(holds(ran.outcome.error->text(),
                      "as the part stands, section 0 (z 2.000 mm) lies outside the machine's travel"))
        << ran.outcome.error->text();
    EXPECT_EQ(machine.count("scan"), 0U);
}

TEST_F(AlignTest, ThePointsMayStandBeforeABestFit) {
    text = session_part_text() + datum_table("blade");
    placed = SessionPart(text);
    const auto ran = run();
    ASSERT_FALSE(ran.outcome.error) << ran.outcome.error->text();
    ASSERT_TRUE(ran.outcome.result.part_frame);
    const auto& alignment = ran.outcome.result.sections.front().alignment;
    EXPECT_EQ(alignment.spec.kind, AlignmentKind::blade);
    EXPECT_EQ(alignment.state, Alignment::State::final);
    EXPECT_LT(alignment.motion.shift_mm.norm(), as_planned_mm);
    EXPECT_TRUE(holds(frame_words(alignment.spec), "from the frame of the six datum points"));
}

TEST_F(AlignTest, PointsOfNobodysTouchesHaveNoDeviations) {
    auto setup = placed.setup(0);
    SectionJudge judge;
    std::vector<RecordedPoint> recorded;
    for (const auto& point : placed.plan.paths[0].points) {
        recorded.emplace_back().sequence = recorded.size();
        recorded.back().centre_mm = point.centre_mm;
    }
    const auto alone = judge.finish(setup, recorded);
    EXPECT_EQ(alone.alignment.state, Alignment::State::refused);
    EXPECT_EQ(alone.find("profile_suction")->decision, Decision::not_evaluable);
    EXPECT_TRUE(alone.find("chord")->value);
    // With a frame, what is not known of it stands in the deviations; sizes feel the height alone.
    PartFrame frame;
    frame.about_mm = {0, 0, 30};
    frame.covariance = 1e-6 * Eigen::Matrix<double, 6, 6>::Identity();
    frame.covariance.bottomRightCorner<3, 3>() *= 1e-4;
    take_frame(setup, frame);
    const auto with = judge.finish(setup, recorded);
    EXPECT_GT(with.deviation_u95_mm(10), 2.0 * 1e-3);
    EXPECT_LT(with.deviation_u95_mm(10), 2.0 * 1.2e-3 + with.fit->contour[10].u95_mm);
    const auto plain = judge.finish(SessionPart().setup(0), recorded);
    EXPECT_NEAR(*alone.find("chord")->u95, *plain.find("chord")->u95, 1e-9);
    EXPECT_GT(*with.find("chord")->u95, *plain.find("chord")->u95)
        << "the blade tapers, its height is not known exactly";
    EXPECT_LT(*with.find("chord")->u95, *plain.find("chord")->u95 + 3e-4);
    EXPECT_GT(with.find("profile_suction")->u95, plain.find("profile_suction")->u95);
}

}  // namespace
}  // namespace cmm::acquisition
