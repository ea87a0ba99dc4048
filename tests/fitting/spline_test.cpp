// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numbers>
#include <vector>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

std::vector<Vec2> circle(std::size_t n, double radius) {
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double a = 2.0 * pi * static_cast<double>(i) / static_cast<double>(n);
        points.emplace_back(radius * std::cos(a), radius * std::sin(a));
    }
    return points;
}

double worst_radius_error(std::size_t n) {
    const auto points = circle(n, 2.0);
    const auto spline = interpolate_periodic(points, chord_parameters(points, true));
    double worst = 0.0;
    for (int k = 0; k < 1000; ++k)
        worst = std::max(worst, std::abs(spline.jet(spline.period() * k / 1000.0).position.norm() - 2.0));
    return worst;
}

TEST(PeriodicSpline, MoreBreaksLeaveItAsItIs) {
    core::Rng rng(5);
    std::vector<Vec2> points;
    for (int k = 0; k < 9; ++k)
        points.emplace_back(rng.normal(), rng.normal());
    const auto spline = interpolate_periodic(points, {-1.0, 0.0, 0.4, 1.0, 2.5, 3.0, 4.0, 4.2, 5.0, 7.0});
    const auto broken = spline.broken_at(std::vector<double>{-0.5, 0.41, 0.42, 0.9, 6.0});
    EXPECT_EQ(broken.breaks(),
              (std::vector<double>{-1.0, -0.5, 0.0, 0.4, 0.41, 0.42, 0.9, 1.0, 2.5, 3.0, 4.0, 4.2, 5.0, 6.0, 7.0}));
    ASSERT_EQ(broken.spans(), 14U);
    EXPECT_TRUE(broken.closed());
    for (int k = 0; k < 1000; ++k) {
        const Jet was = spline.jet(-1.0 + 0.008 * k), is = broken.jet(-1.0 + 0.008 * k);
        EXPECT_LT((was.position - is.position).norm() + (was.d1 - is.d1).norm() + (was.d2 - is.d2).norm(), 1e-12) << k;
    }
    EXPECT_EQ(spline.broken_at({}).breaks(), spline.breaks());
}

TEST(PeriodicSpline, ControlsAreItsBlossomsOnUnevenKnots) {
    core::Rng rng(3);
    std::vector<Vec2> points;
    std::vector<double> t{-2.0};
    for (int k = 0; k < 11; ++k) {
        points.emplace_back(rng.normal(), rng.normal());
        t.push_back(t.back() + rng.uniform(0.05, 3.0));
    }
    const PeriodicInterpolation interpolation(t);
    const auto spline = interpolation.through(points);
    const auto controls = interpolation.controls(points);
    ASSERT_EQ(controls.size(), points.size());
    for (std::size_t k = 2; k < points.size(); ++k)
        EXPECT_LT((controls[k] - spline.blossom(t[k - 2], t[k - 1], t[k])).norm(), 1e-12) << k;
    const double period = t.back() - t.front();
    EXPECT_LT((controls[0] - spline.blossom(t[9] - period, t[10] - period, t[0])).norm(), 1e-12);
    EXPECT_LT((controls[1] - spline.blossom(t[10] - period, t[0], t[1])).norm(), 1e-12);
}

/// The blossoms at neighbouring knots are the controls of de Boor's algorithm.
TEST(PeriodicSpline, BlossomsAreItsControls) {
    const auto points = circle(9, 1.5);
    const auto spline = interpolate_periodic(points, chord_parameters(points, true));
    const auto knot = [&](int k) {
        const int n = static_cast<int>(spline.spans());
        const int turns = k < 0 ? -1 : k / n;
        return spline.breaks()[static_cast<std::size_t>(k - turns * n)] + turns * spline.period();
    };
    for (int k = 0; k < 9; ++k) {
        const double t = 0.3 * knot(k) + 0.7 * knot(k + 1);
        std::array<Vec2, 4> d;
        for (int a = 0; a < 4; ++a)
            d[static_cast<std::size_t>(a)] = spline.blossom(knot(k + a - 2), knot(k + a - 1), knot(k + a));
        for (int r = 1; r <= 3; ++r)
            for (int a = 3; a >= r; --a) {
                const double left = knot(k + a - 3), right = knot(k + a - r + 1), share = (t - left) / (right - left);
                auto& to = d[static_cast<std::size_t>(a)];
                to = (1.0 - share) * d[static_cast<std::size_t>(a - 1)] + share * to;
            }
        EXPECT_LT((d[3] - spline.jet(t).position).norm(), 1e-13) << k;
    }
}

TEST(PeriodicSpline, GoesThroughItsPointsWithTwoContinuousDerivatives) {
    const auto points = circle(9, 1.5);
    const auto spline = interpolate_periodic(points, chord_parameters(points, true));
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double t = spline.breaks()[i], step = 1e-7;
        EXPECT_LT((spline.jet(t).position - points[i]).norm(), 1e-14);
        EXPECT_LT((spline.jet(t + step).d1 - spline.jet(t - step).d1).norm(), 1e-6);
        EXPECT_LT((spline.jet(t + step).d2 - spline.jet(t - step).d2).norm(), 1e-5);
    }
}

TEST(PeriodicSpline, ConvergesOnACircleWithTheFourthPower) {
    const double coarse = worst_radius_error(16), fine = worst_radius_error(32);
    EXPECT_LT(coarse, 2e-4);
    EXPECT_NEAR(coarse / fine, 16.0, 3.0);
}

TEST(PeriodicSpline, TakesAnyParameterOfThePeriod) {
    const auto points = circle(11, 1.0);
    const auto spline = interpolate_periodic(points, chord_parameters(points, true));
    for (const double turns : {-3.0, -1.0, 1.0, 2.0})
        EXPECT_LT((spline.jet(0.7).position - spline.jet(0.7 + turns * spline.period()).position).norm(), 1e-12);
}

TEST(OpenSpline, WithGivenEndDerivativesReproducesACubic) {
    const auto cubic = [](double t) { return Vec2(1.0 + t - 2.0 * t * t + 0.5 * t * t * t, 2.0 - t * t * t); };
    const auto slope = [](double t) { return Vec2(1.0 - 4.0 * t + 1.5 * t * t, -3.0 * t * t); };
    std::vector<double> t{0.0, 0.4, 1.1, 1.5, 2.3};
    std::vector<Vec2> points;
    for (const double at : t)
        points.push_back(cubic(at));
    const auto spline =
        interpolate_open(points, t, SplineEnd::derivative(slope(0.0)), SplineEnd::derivative(slope(2.3)));
    for (double at = 0.0; at <= 2.3; at += 0.05) {
        EXPECT_LT((spline.jet(at).position - cubic(at)).norm(), 1e-12);
        EXPECT_LT((spline.jet(at).d1 - slope(at)).norm(), 1e-11);
    }
}

TEST(OpenSpline, NaturalEndsHaveNoSecondDerivative) {
    const std::vector<Vec2> points{{0, 0}, {1, 2}, {3, 1}, {4, 4}};
    const auto spline = interpolate_open(points, chord_parameters(points, false));
    EXPECT_LT(spline.jet(spline.breaks().front()).d2.norm(), 1e-13);
    EXPECT_LT(spline.jet(spline.breaks().back()).d2.norm(), 1e-13);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT((spline.jet(spline.breaks()[i]).position - points[i]).norm(), 1e-13);
}

/// Not a knot: a cubic comes back without its derivatives being told; the third derivative does not jump.
TEST(OpenSpline, NotAKnotReproducesACubic) {
    const auto cubic = [](double t) { return Vec2(1.0 + t - 2.0 * t * t + 0.5 * t * t * t, 2.0 - t * t * t); };
    const auto slope = [](double t) { return Vec2(1.0 - 4.0 * t + 1.5 * t * t, -3.0 * t * t); };
    const SplineEnd loose = SplineEnd::not_a_knot();
    const std::vector<double> t{0.0, 0.4, 1.1, 1.5, 2.3};
    for (const std::size_t n : {4U, 5U}) {
        const std::vector<double> at(t.begin(), t.begin() + static_cast<std::ptrdiff_t>(n));
        std::vector<Vec2> points;
        for (const double u : at)
            points.push_back(cubic(u));
        const auto both = interpolate_open(points, at, loose, loose);
        const auto start = interpolate_open(points, at, loose, SplineEnd::derivative(slope(at.back())));
        const auto end = interpolate_open(points, at, SplineEnd::derivative(slope(0.0)), loose);
        for (double u = 0.0; u <= at.back(); u += 0.05)
            for (const auto* spline : {&both, &start, &end})
                EXPECT_LT((spline->jet(u).position - cubic(u)).norm(), 1e-12) << n << " " << u;
    }
    const std::vector<Vec2> rough{{0, 0}, {1, 2}, {3, 1}, {4, 4}, {6, 0}};
    const auto spline = interpolate_open(rough, t, loose, SplineEnd());
    EXPECT_LT((spline.pieces()[0][3] - spline.pieces()[1][3]).norm(), 1e-12);
    EXPECT_LT(spline.jet(2.3).d2.norm(), 1e-12);
}

TEST(OpenSpline, NotAKnotWithFewPointsHasTheLowestDegree) {
    const SplineEnd loose = SplineEnd::not_a_knot();
    const auto parabola = [](double t) { return Vec2(t, 1.0 - t + 2.0 * t * t); };
    const std::vector<double> t{0.0, 0.5, 2.0};
    const std::vector<Vec2> three{parabola(0.0), parabola(0.5), parabola(2.0)};
    const auto through = interpolate_open(three, t, loose, loose);
    const std::vector<double> ends{0.0, 2.0};
    const std::vector<Vec2> two{parabola(0.0), parabola(2.0)};
    const auto line = interpolate_open(two, ends, loose, loose);
    const auto rising = interpolate_open(two, ends, SplineEnd::derivative({1.0, -1.0}), loose);
    const auto falling = interpolate_open(two, ends, loose, SplineEnd::derivative({1.0, 7.0}));
    for (double u = 0.0; u <= 2.0; u += 0.1) {
        for (const auto* spline : {&through, &rising, &falling})
            EXPECT_LT((spline->jet(u).position - parabola(u)).norm(), 1e-13);
        EXPECT_LT((line.jet(u).position - (two[0] + 0.5 * u * (two[1] - two[0]))).norm(), 1e-14);
    }
}

TEST(Jet, CurvatureOfALeftTurnIsPositive) {
    const auto points = circle(64, 0.5);
    const auto spline = interpolate_periodic(points, chord_parameters(points, true));
    EXPECT_NEAR(spline.jet(1.0).curvature(), 2.0, 2e-2);
    EXPECT_GT(spline.jet(1.0).right_normal().dot(spline.jet(1.0).position), 0.0);
}

}  // namespace
}  // namespace cmm::fitting
