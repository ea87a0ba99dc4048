// SPDX-License-Identifier: Apache-2.0
#include "fitting/live_curve.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "core/rng.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

constexpr double pi = std::numbers::pi;

TEST(LiveCurve, KnowsTheFrameAndCurvatureOfACircleEitherWay) {
    for (const double sense : {1.0, -1.0}) {
        LiveCurve curve(sense > 0 ? MaterialSide::left : MaterialSide::right);
        core::Rng rng(3);
        for (int k = 0; k < 40; ++k) {
            const double a = sense * 0.1 * k / 1.2;
            curve.add((1.2 + 0.001 * rng.normal()) * Vec2(std::cos(a), std::sin(a)));
        }
        ASSERT_TRUE(curve.local().valid);
        EXPECT_NEAR(curve.local().curvature, 1.0 / 1.2, 0.12);
        EXPECT_GT(curve.local().normal.dot(curve.points().back().normalized()), 0.995);
        EXPECT_NEAR(curve.turned_rad(), 0.1 * 39 / 1.2, 0.3);
    }
}

/// The way acquisition drives round an unknown blade: predict, touch what is there, add.
TEST(LiveCurve, LeadsRoundABladeEitherWay) {
    for (const double ball : {0.5, 1.0, 2.0}) {
        const auto centres = truth::ball_centres(truth::envelope_blade({45, 3, 25, 40, 0.25, 0.15}), ball);
        const std::size_t n = centres.points.size();
        for (const bool clockwise : {false, true}) {
            LiveCurve curve(clockwise ? MaterialSide::right : MaterialSide::left);
            core::Rng rng(8);
            std::size_t at = 6000;  // in the middle of a side
            double worst = 0.0;
            const auto touch = [&](const Vec2& aim) {
                std::size_t best = at;
                for (std::size_t k = 0; k < 2000; ++k) {
                    const std::size_t i = (at + n + (clockwise ? -k : k)) % n;
                    if ((centres.points[i] - aim).squaredNorm() < (centres.points[best] - aim).squaredNorm()) best = i;
                }
                at = best;
                worst = std::max(worst, (centres.points[at] - aim).norm());
                return Vec2(centres.points[at] + 0.001 * rng.normal() * centres.normals[at]);
            };
            for (int k = 0; k < 4; ++k)
                curve.add(touch(centres.points[(at + n + (clockwise ? -30 : 30)) % n]));
            worst = 0.0;
            int steps = 0;
            for (; steps < 4000 && !curve.closed(); ++steps) {
                const auto next = curve.predict(curve.suggest_step(0.05, 0.4, 0.002));
                ASSERT_TRUE(next.valid);
                EXPECT_GT(next.normal.dot(centres.normals[at]), 0.7) << "outward";
                curve.add(touch(next.centre));
            }
            EXPECT_TRUE(curve.closed()) << ball;
            // A step of 0.4 mm straight on where the TE begins misses by its sagitta; the next, careful one by little
            // more.
            EXPECT_LT(worst, 0.4 * 0.4 / 2.0 / (ball + 0.15) + 0.07) << ball;
            EXPECT_NEAR(curve.length_mm(), centres.perimeter(), 2.0);
            EXPECT_NEAR(curve.turned_rad(), 2.0 * pi, 0.3);
        }
    }
}

TEST(LiveCurve, OneBadPointDoesNotTurnTheHead) {
    for (const double bad : {0.03, 0.1, 0.3, -0.1}) {
        LiveCurve curve(MaterialSide::left);
        core::Rng rng(11);
        for (int k = 0; k < 20; ++k) {
            const double a = 0.1 * k / 2.0;
            const double r = 2.0 + 0.001 * rng.normal() + (k == 19 ? bad : 0.0);
            curve.add(r * Vec2(std::cos(a), std::sin(a)));
            if (k < 19) continue;
            EXPECT_TRUE(curve.local().last_is_bad);
            const Vec2 tangent(-std::sin(a), std::cos(a));
            EXPECT_GT(curve.local().tangent.dot(tangent), 0.998) << bad;
            EXPECT_NEAR(curve.predict(0.1).centre.norm(), 2.0, 0.01) << bad;
        }
    }
}

TEST(LiveCurve, StepFollowsTheChordError) {
    LiveCurve curve(MaterialSide::left);
    EXPECT_DOUBLE_EQ(curve.suggest_step(0.05, 0.5, 0.001), 0.05) << "nothing known: careful";
    for (int k = 0; k < 20; ++k)
        curve.add({0.2 * k, 0.0});
    EXPECT_DOUBLE_EQ(curve.suggest_step(0.05, 0.5, 0.001), 0.5);
    LiveCurve round(MaterialSide::left);
    for (int k = 0; k < 20; ++k)
        round.add({std::cos(0.05 * k), std::sin(0.05 * k)});
    EXPECT_NEAR(round.suggest_step(0.01, 0.5, 0.001), std::sqrt(0.008), 0.003);
    EXPECT_DOUBLE_EQ(round.suggest_step(0.2, 0.5, 0.001), 0.2);
}

TEST(LiveCurve, IgnoresRepeatedAndBrokenPoints) {
    LiveCurve curve(MaterialSide::left);
    curve.add({0, 0});
    curve.add({0, 0});
    curve.add({std::nan(""), 1});
    EXPECT_EQ(curve.size(), 1U);
    EXPECT_FALSE(curve.predict(0.1).valid);
    EXPECT_FALSE(curve.closed());
}

TEST(LiveCurve, SideFromTheFirstTouch) {
    EXPECT_EQ(material_side({1, 0}, {0, 1}), MaterialSide::left);
    EXPECT_EQ(material_side({-1, 0}, {0, 1}), MaterialSide::right);
}

}  // namespace
}  // namespace cmm::fitting
