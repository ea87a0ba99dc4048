// SPDX-License-Identifier: Apache-2.0
#include "fitting/bridge.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using Curve = std::function<Vec2(double)>;

/// Neighbours of the gap left by `missing` points of a curve in steps of its parameter, the nearest first.
Neighbours around(const Curve& curve, double step, int missing, std::size_t before, std::size_t after, double sigma,
                  core::Rng& rng) {
    Neighbours near;
    const auto at = [&](double t) {
        const Vec2 tangent = (curve(t + 1e-6) - curve(t - 1e-6)).normalized();
        return Vec2(curve(t) + sigma * rng.normal() * right_normal(tangent));
    };
    const double half = 0.5 * (missing + 1) * step;
    for (near.count_before = 0; near.count_before < before; ++near.count_before)
        near.before[near.count_before] = at(-half - static_cast<double>(near.count_before) * step);
    for (near.count_after = 0; near.count_after < after; ++near.count_after)
        near.after[near.count_after] = at(half + static_cast<double>(near.count_after) * step);
    return near;
}

Curve circle(double radius) {
    return [radius](double s) { return Vec2(radius * std::sin(s / radius), radius * (1.0 - std::cos(s / radius))); };
}

TEST(Bridge, OnACircleOfAnyRadiusThePredictionIsExact) {
    core::Rng rng(1);
    for (const double radius : {0.2, 1.3, 50.0, 1e6}) {
        const double step = std::min(0.06, 0.2 * radius);
        const auto near = around(circle(radius), step, 3, 8, 8, 0.0, rng);
        const Vec2 out =
            circle(radius)(0.3 * step) + 0.030 * Vec2(std::sin(0.3 * step / radius), -std::cos(0.3 * step / radius));
        const Verdict verdict = judge_point(near, out, 1e-3);
        EXPECT_TRUE(verdict.resolved && !verdict.corner) << radius;
        EXPECT_NEAR(verdict.residual_mm, 0.030, 1e-8) << radius << ": positive on the right of the travel";
    }
}

/// The sd is that of the residual of a good point: ratios of good points are standard normal, or smaller where the
/// model's error is counted.
TEST(Bridge, TheStatedDeviationIsTheTrueOne) {
    const Curve ellipse = [](double t) { return Vec2(2.0 * std::sin(t), 1.4 * (1.0 - std::cos(t))); };
    for (const int missing : {1, 3, 5}) {
        core::Rng rng(7);
        double squares = 0.0, variance = 0.0;
        int beyond = 0, all = 0;
        for (int trial = 0; trial < 4000; ++trial) {
            const auto near = around(ellipse, 0.04, missing, 8, 8, 1e-3, rng);
            const Verdict verdict = judge_point(near, ellipse(0.0) + 1e-3 * rng.normal() * Vec2(0, 1), 1e-3);
            ASSERT_TRUE(verdict.resolved);
            squares += verdict.residual_mm * verdict.residual_mm;
            variance += verdict.sd_mm * verdict.sd_mm;
            beyond += std::abs(verdict.ratio()) > 3.0;
            ++all;
        }
        EXPECT_LT(squares, 1.1 * variance) << missing;
        EXPECT_GT(squares, 0.6 * variance) << missing;
        EXPECT_LT(beyond, 0.01 * all) << missing;
    }
}

TEST(Bridge, APointNextToACornerBelongsToItsSide) {
    core::Rng rng(3);
    const Curve corner = [](double s) { return s < 0 ? Vec2(s, 0) : Vec2(std::cos(0.4) * s, std::sin(0.4) * s); };
    auto near = around(corner, 0.3, 1, 8, 8, 0.5e-3, rng);
    near.before[0] = {-0.35, 0.0};  // the corner lies between the point and what comes before it
    Verdict verdict = judge_point(near, corner(0.02), 0.5e-3);
    EXPECT_TRUE(verdict.resolved);
    EXPECT_LT(std::abs(verdict.ratio()), 4.0);
    verdict = judge_point(near, corner(0.02) + Vec2(0, -0.08), 0.5e-3);
    EXPECT_GT(std::abs(verdict.ratio()), 5.0) << "neither side";
}

/// Two sides on different levels: between them any level may be, beyond both none.
TEST(Bridge, BesideAStepAPointBeyondBothLevelsIsNotGood) {
    core::Rng rng(4);
    const Curve step = [](double s) { return Vec2(s, s < 0 ? 0.0 : 0.05); };
    const auto near = around(step, 0.1, 1, 8, 8, 0.5e-3, rng);
    for (const double level : {-0.1, 0.15}) {
        const Verdict verdict = judge_point(near, {0.0, level}, 0.5e-3);
        EXPECT_FALSE(verdict.resolved && std::abs(verdict.ratio()) < 3.0) << level;
    }
}

TEST(Bridge, AnEndIsJudgedByItsOneSide) {
    core::Rng rng(5);
    const auto near = around(circle(3.0), 0.1, 1, 0, 8, 1e-3, rng);
    EXPECT_LT(std::abs(judge_point(near, circle(3.0)(0.0), 1e-3).ratio()), 4.0);
    const Verdict bad = judge_point(near, circle(3.0)(0.0) + Vec2(0, -0.03), 1e-3);
    EXPECT_TRUE(bad.resolved);
    EXPECT_GT(bad.ratio(), 5.0);
}

TEST(Bridge, FewOrUnusablePointsSayNothing) {
    Neighbours none;
    EXPECT_FALSE(judge_point(none, {0, 0}, 1e-3).resolved);
    Neighbours same;
    same.before.fill({1, 1});
    same.after.fill({1, 1});
    same.count_before = same.count_after = Neighbours::most;
    EXPECT_TRUE(std::isfinite(judge_point(same, {1, 2}, 1e-3).residual_mm));
    core::Rng rng(6);
    for (int trial = 0; trial < 2000; ++trial) {
        Neighbours random;
        random.count_before = rng.below(Neighbours::most + 1);
        random.count_after = rng.below(Neighbours::most + 1);
        for (auto* side : {&random.before, &random.after})
            for (Vec2& p : *side)
                p = Vec2(rng.normal(), trial % 3 == 0 ? 0.0 : rng.normal());
        const Verdict verdict = judge_point(random, {rng.normal(), rng.normal()}, 1e-3);
        EXPECT_TRUE(std::isfinite(verdict.residual_mm) && std::isfinite(verdict.sd_mm));
    }
}

}  // namespace
}  // namespace cmm::fitting
