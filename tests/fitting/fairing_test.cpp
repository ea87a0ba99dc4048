// SPDX-License-Identifier: Apache-2.0
#include "fitting/fairing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

/// An ellipse of 30 x 6 mm half axes through points that are off by `noise`, one of them by `bump` more.
PiecewiseCubic wavy(double noise, double bump, std::uint64_t seed, std::size_t n = 120) {
    core::Rng rng(seed);
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double a = 2.0 * pi * static_cast<double>(i) / static_cast<double>(n);
        const Vec2 normal = Vec2(6.0 * std::cos(a), 30.0 * std::sin(a)).normalized();
        points.push_back(Vec2(30.0 * std::cos(a), 6.0 * std::sin(a)) +
                         (noise * rng.normal() + (i == n / 3 ? bump : 0.0)) * normal);
    }
    return interpolate_periodic(points, chord_parameters(points, true));
}

/// Variation of the curvature along the curve, summed without its sign.
double curvature_variation(const PiecewiseCubic& curve) {
    double sum = 0.0, last = curve.jet(0.0).curvature();
    for (int i = 1; i <= 20000; ++i) {
        const double now = curve.jet(curve.period() * i / 20000.0).curvature();
        sum += std::abs(now - last);
        last = now;
    }
    return sum;
}

double farthest_apart(const PiecewiseCubic& a, const PiecewiseCubic& b) {
    double most = 0.0;
    for (int i = 0; i < 5000; ++i)
        most =
            std::max(most, (a.jet(a.period() * i / 5000.0).position - b.jet(a.period() * i / 5000.0).position).norm());
    return most;
}

TEST(Fairing, CurvatureVariesLessAndNothingMovesFartherThanAllowed) {
    for (const double most : {0.0005, 0.002, 0.01}) {
        const auto curve = wavy(0.001, 0.01, 7);
        const auto faired = fair_closed(curve, most);
        ASSERT_TRUE(faired) << faired.error().message;
        EXPECT_GT(faired->moves, 0U);
        EXPECT_LE(faired->largest_mm, most + 1e-12);
        EXPECT_LE(farthest_apart(curve, faired->curve), faired->largest_mm + 1e-12);
        EXPECT_LT(faired->after, faired->before);
        EXPECT_LT(curvature_variation(faired->curve), curvature_variation(curve)) << most;
    }
    const auto curve = wavy(0.001, 0.01, 7);
    const double own = curvature_variation(wavy(0.0, 0.0, 7));  // of the ellipse
    EXPECT_LT(curvature_variation(fair_closed(curve, 0.01)->curve) - own, 0.1 * (curvature_variation(curve) - own));
}

/// A single bad point: most of it goes, and the rest of the curve stays.
TEST(Fairing, TakesABumpAwayWhereItIs) {
    const auto clean = wavy(0.0, 0.0, 1), bumped = wavy(0.0, 0.01, 1);
    const auto faired = fair_closed(bumped, 0.02);
    ASSERT_TRUE(faired);
    const double before = farthest_apart(clean, bumped), after = farthest_apart(clean, faired->curve);
    EXPECT_GT(before, 0.009);
    EXPECT_LT(after, 0.5 * before);
}

TEST(Fairing, IsDoneAfterOnce) {
    const auto curve = wavy(0.001, 0.0, 3);
    const auto once = fair_closed(curve, 0.05);
    ASSERT_TRUE(once);
    const auto twice = fair_closed(once->curve, 0.05);
    ASSERT_TRUE(twice);
    EXPECT_LT(twice->largest_mm, 0.05 * once->largest_mm);
    EXPECT_GT(twice->after, 0.9 * once->after);
}

TEST(Fairing, KeepsTheCurveTwiceDifferentiableAndItsParameter) {
    const auto curve = wavy(0.002, 0.0, 4);
    const auto faired = fair_closed(curve, 0.01);
    ASSERT_TRUE(faired);
    ASSERT_EQ(faired->curve.spans(), curve.spans());
    for (std::size_t k = 0; k < curve.spans(); ++k) {
        EXPECT_NEAR(faired->curve.breaks()[k], curve.breaks()[k], 1e-9);
        const auto& p = faired->curve.pieces()[k];
        const auto& next = faired->curve.pieces()[(k + 1) % curve.spans()];
        const double h = faired->curve.breaks()[k + 1] - faired->curve.breaks()[k];
        EXPECT_LT((p[2] + 3.0 * h * p[3] - next[2]).norm(), 1e-8);
    }
}

TEST(Fairing, NothingIsAllowedAndNothingMoves) {
    const auto curve = wavy(0.001, 0.0, 5);
    const auto faired = fair_closed(curve, 0.0);
    ASSERT_TRUE(faired);
    EXPECT_EQ(faired->largest_mm, 0.0);
    EXPECT_LT(farthest_apart(curve, faired->curve), 1e-12);
    EXPECT_FALSE(fair_closed(curve, -1.0));
    const std::vector<Vec2> few{{0, 0}, {1, 0}, {1, 1}};
    EXPECT_FALSE(fair_closed(interpolate_periodic(few, chord_parameters(few, true)), 0.1));
}

}  // namespace
}  // namespace cmm::fitting
