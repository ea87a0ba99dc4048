// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

std::vector<Vec2> ellipse(std::size_t n, double sigma, std::uint64_t seed) {
    core::Rng rng(seed);
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        points.emplace_back(20.0 * std::cos(t) + sigma * rng.normal(), 4.0 * std::sin(t) + sigma * rng.normal());
    }
    return points;
}

double worst_error(const SmoothCurve& smooth) {
    double worst = 0.0;
    for (int k = 0; k < 4000; ++k) {
        const Vec2 p = smooth.curve.jet(smooth.curve.period() * k / 4000.0).position;
        const Vec2 gradient(p.x() / 200.0, p.y() / 8.0);  // first-order distance to the ellipse
        worst = std::max(worst, std::abs(p.x() * p.x() / 400.0 + p.y() * p.y() / 16.0 - 1.0) / gradient.norm());
    }
    return worst;
}

TEST(Smoothing, FollowsExactPoints) {
    const auto smooth = smooth_closed(ellipse(400, 0.0, 1), 0.0);
    ASSERT_TRUE(smooth);
    EXPECT_LT(worst_error(*smooth), 5e-4);
}

TEST(Smoothing, AveragesNoiseByFewKnots) {
    const auto smooth = smooth_closed(ellipse(4000, 0.001, 2), 0.001);
    ASSERT_TRUE(smooth);
    EXPECT_LT(smooth->curve.spans(), 600U);
    EXPECT_LT(worst_error(*smooth), 0.0016) << "the noise itself reaches 0.0035";
    double squares = 0.0;
    for (const double r : smooth->residual)
        squares += r * r;
    EXPECT_NEAR(std::sqrt(squares / 4000.0), 0.001, 1e-4);
}

/// The leverage is the variance of the curve over that of a point: compare with the scatter over many runs.
TEST(Smoothing, LeverageIsTheVarianceThatRemains) {
    double squares = 0.0, stated = 0.0;
    const int runs = 200;
    for (int k = 0; k < runs; ++k) {
        const auto smooth = smooth_closed(ellipse(2000, 0.001, 100 + k), 0.001);
        ASSERT_TRUE(smooth);
        const Vec2 p = smooth->curve.jet(smooth->curve.period() * 0.25).position;  // top: error is y - 4 in first order
        const double error = 4.0 * std::sqrt(1.0 - p.x() * p.x() / 400.0) - p.y();
        double t = smooth->curve.period() * 0.25;
        squares += error * error / runs;
        stated += 1e-6 * smooth->leverage[smooth->curve.span_of(t)] / runs;
    }
    EXPECT_GT(squares, 0.3 * stated);
    EXPECT_LT(squares, 3.0 * stated);
}

TEST(Smoothing, KnotsGatherWhereItCurves) {
    const auto smooth = smooth_closed(ellipse(2000, 0.001, 3), 0.001);
    ASSERT_TRUE(smooth);
    std::size_t tips = 0, sides = 0;
    const auto& curve = smooth->curve;
    for (std::size_t k = 0; k < curve.spans(); ++k)
        ++(std::abs(curve.pieces()[k][0].x()) > 18.0 ? tips : sides);
    EXPECT_GT(static_cast<double>(tips) / 14.0, static_cast<double>(sides) / 74.0) << "knots per millimetre";
}

TEST(Smoothing, RefusesTooFewPoints) {
    EXPECT_FALSE(smooth_closed(ellipse(11, 0.0, 1), 0.0));
}

}  // namespace
}  // namespace cmm::fitting
