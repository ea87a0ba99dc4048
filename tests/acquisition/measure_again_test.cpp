// SPDX-License-Identifier: Apache-2.0
#include "acquisition/measure_again.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/acquisition/until_decided_trials.hpp"

namespace cmm::acquisition {
namespace {

using decisions::half_zone_mm;
using decisions::Probe;
using fitting::Zone;

/// A compressor blade, 2 um of noise; its suction side swells to a share of what the zone allows.
struct MeasureAgainTest : ::testing::Test {
    fitting::families::Blade blade = fitting::families::make(fitting::families::Family::compressor, 5);
    SectionSetup setup = decisions::setup_of(blade, 0.0);
    PlannedPath lap = decisions::planned_lap(setup, 600);
    UntilDecided bound;

    Probe probe(double share) const {
        return {blade, [share](double t) { return share * half_zone_mm * decisions::swelling(t, 0.08); }, 2e-3, 7};
    }
    std::vector<RecordedPoint> points_of(double share) const {
        std::vector<RecordedPoint> points;
        auto touching = probe(share);
        touching.measure(lap.points, 0, points);
        return points;
    }
    SectionResult judged(std::vector<RecordedPoint> points) const {
        return SectionJudge().finish(setup, std::move(points));
    }
    std::optional<AgainPass> plan(const SectionResult& result) const { return plan_again(result, setup, lap, bound); }
};

TEST_F(MeasureAgainTest, WhatIsDecidedIsNotMeasuredAgain) {
    for (const double share : {0.3, 1.7}) {
        const auto result = judged(points_of(share));
        ASSERT_NE(result.decision(), Decision::undecided);
        EXPECT_FALSE(plan(result)) << share;
    }
}

TEST_F(MeasureAgainTest, OnlyThePlacesThatMayBeOutAreMeasuredAgain) {
    const auto result = judged(points_of(0.95));
    ASSERT_EQ(result.find("profile_suction")->decision, Decision::undecided);
    const auto pass = plan(result);
    ASSERT_TRUE(pass);
    EXPECT_EQ(pass->because, std::vector<std::string>{"profile_suction"});
    ASSERT_EQ(pass->stretches.size(), 1U);
    EXPECT_GT(pass->points(), 20U);
    EXPECT_LT(pass->points(), 300U);
    EXPECT_GT(pass->duration_s, 1.0);
    const auto top = blade.at(3.5).position;
    for (const auto& point : pass->stretches.front()) {
        EXPECT_LT((point.centre_mm.head<2>() - top).norm(), 0.25 * blade.shape().chord);
        EXPECT_NEAR(std::abs(blade.distance(point.centre_mm.head<2>())), decisions::ball_mm, 0.002);
        EXPECT_TRUE(point.record);
        EXPECT_GT(point.speed_mm_s, 0.0);
    }
}

/// What was not measured is asked for where it leaves something open, also beside what is to be denser.
TEST_F(MeasureAgainTest, AGapIsMeasuredAgainWhereItLeavesSomethingOpen) {
    auto points = points_of(0.95);
    const Eigen::Vector2d lost = blade.at(1.5).position;
    const auto is_lost = [&](const RecordedPoint& point) {
        return (point.centre_mm.head<2>() - lost).norm() < 0.06 * blade.shape().chord;  // of this side only
    };
    const auto missing = static_cast<std::size_t>(std::count_if(points.begin(), points.end(), is_lost));
    ASSERT_GT(missing, 10U);
    std::erase_if(points, is_lost);
    auto result = judged(points);
    ASSERT_EQ(result.gaps().size(), 1U);
    const auto both = plan(result);
    ASSERT_TRUE(both);
    EXPECT_EQ(both->because, (std::vector<std::string>{"profile_suction", "profile_pressure"}));
    ASSERT_EQ(both->stretches.size(), 2U);
    EXPECT_EQ(std::min(both->stretches[0].size(), both->stretches[1].size()), missing);
    for (auto& c : result.characteristics) {
        if (c.name != "profile_pressure") continue;
        c.upper.reset();
        c.decision = Decision::reported;
    }
    const auto denser = plan(result);
    ASSERT_TRUE(denser);
    EXPECT_EQ(denser->because, std::vector<std::string>{"profile_suction"});
    EXPECT_EQ(denser->points(), both->points() - missing);
}

/// The same from the same points: a run that was cut off goes on with the pass that it had begun.
TEST_F(MeasureAgainTest, ThePlanFollowsFromThePoints) {
    const auto result = judged(points_of(0.95));
    const auto one = plan(result), other = plan(judged(points_of(0.95)));
    ASSERT_TRUE(one && other);
    ASSERT_EQ(one->points(), other->points());
    for (std::size_t i = 0; i < one->stretches.front().size(); ++i)
        EXPECT_EQ(one->stretches.front()[i].centre_mm, other->stretches.front()[i].centre_mm);
}

TEST_F(MeasureAgainTest, ASecondPassLiesBetweenThePointsOfTheFirst) {
    auto points = points_of(0.97);
    const auto plan_at = [&](double share_of_guard) {
        auto result = judged(points);
        for (auto& c : result.characteristics) {
            if (c.name != "profile_suction") continue;
            c.decision = Decision::undecided;
            c.value = *c.upper - share_of_guard * *c.guard_accept;
        }
        return plan(result);
    };
    const auto first = plan_at(0.8);
    ASSERT_TRUE(first);
    auto touching = probe(0.97);
    for (const auto& stretch : first->stretches)
        touching.measure(stretch, 1, points);
    const auto second = plan_at(0.95);
    ASSERT_TRUE(second);
    for (const auto& point : second->stretches.front())
        for (const auto& known : points)
            EXPECT_GT((known.centre_mm - point.centre_mm).head<2>().norm(), 0.008);
}

/// Undecided because of the machine: no number of points helps.
TEST_F(MeasureAgainTest, WhatTheMachineLeavesOpenIsNotMeasuredAgain) {
    ASSERT_TRUE(plan(judged(points_of(0.95))));
    fitting::SystematicErrors errors;
    errors.ball_mm = 0.002;
    setup.fields = fitting::ErrorFields(errors, 0.0);
    const auto result = judged(points_of(0.95));
    ASSERT_EQ(result.find("profile_suction")->decision, Decision::undecided);
    EXPECT_FALSE(plan(result));
    // A little of it leaves room for more points.
    errors.ball_mm = 0.0001;
    setup.fields = fitting::ErrorFields(errors, 0.0);
    EXPECT_TRUE(plan(judged(points_of(0.95))));
}

TEST_F(MeasureAgainTest, WhatWouldNeedTooManyPointsOrTooLongIsLeft) {
    auto result = judged(points_of(0.95));
    for (auto& c : result.characteristics)
        if (c.name == "profile_suction") c.value = *c.upper - 0.05 * *c.guard_accept;
    EXPECT_FALSE(plan(result));
    const auto near = judged(points_of(0.95));
    const auto pass = plan(near);
    ASSERT_TRUE(pass);
    bound.seconds = 0.5 * pass->duration_s;
    EXPECT_FALSE(plan(near));
}

TEST_F(MeasureAgainTest, AnEdgeIsMeasuredAgainForItsThicknessAndBothForTheChord) {
    setup.gate.profile_mm.reset();
    setup.gate.edge_profile_mm.reset();
    const auto zones_for = [&](CharacteristicKind kind) {
        CharacteristicSpec spec;
        spec.kind = kind;
        spec.label = "asked";
        spec.above = 0.001;
        spec.nominal = 0.0;
        spec.distance_mm = 3.0;
        setup.gate.characteristics = {spec};
        auto result = judged(points_of(0.0));
        std::set<Zone> zones;
        for (auto& c : result.characteristics) {
            if (c.name != "asked") continue;
            c.upper = *c.value + 0.7 * *c.guard_accept;
            c.decision = Decision::undecided;
        }
        const auto pass = plan(result);
        if (!pass) return zones;
        for (const auto& stretch : pass->stretches) {
            const auto middle = stretch[stretch.size() / 2].centre_mm.head<2>();
            zones.insert(setup.nominal->section.zone_at(setup.nominal->section.curve().closest(middle).s_mm));
        }
        return zones;
    };
    EXPECT_EQ(zones_for(CharacteristicKind::le_thickness), std::set<Zone>{Zone::le});
    EXPECT_EQ(zones_for(CharacteristicKind::chord), (std::set<Zone>{Zone::le, Zone::te}));
    EXPECT_EQ(zones_for(CharacteristicKind::max_thickness), (std::set<Zone>{Zone::suction, Zone::pressure}));
}

/// Four times the points where it matters, half the guard band there.
TEST_F(MeasureAgainTest, PointsOfAPassSharpenTheDecision) {
    auto points = points_of(0.95);
    const auto before = judged(points);
    const auto pass = plan(before);
    ASSERT_TRUE(pass);
    auto touching = probe(0.95);
    for (const auto& stretch : pass->stretches)
        touching.measure(stretch, 1, points);
    const auto after = judged(points);
    EXPECT_LT(*after.find("profile_suction")->guard_accept, 0.85 * *before.find("profile_suction")->guard_accept);
    EXPECT_LT(after.rejected(), 4U) << "the points of the pass are in the fit";
}

}  // namespace
}  // namespace cmm::acquisition
