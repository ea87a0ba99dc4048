// SPDX-License-Identifier: Apache-2.0
#include "fitting/closest_point.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/rng.hpp"
#include "fitting/closed_curve.hpp"

namespace cmm::fitting {
namespace {

constexpr double nanometre = 1e-6;

/// 60 mm long, 5 mm thick, edges of 0.2 mm radius where its 120 spans are 0.1 mm long; bent.
PiecewiseCubic thin_blade() {
    std::vector<Vec2> points;
    for (int i = 0; i < 120; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 120.0;
        points.emplace_back(30.0 * std::cos(a), 2.5 * std::sin(a) + 8.0 * std::cos(a) * std::cos(a));
    }
    return interpolate_periodic(points, chord_parameters(points, true));
}

/// Every local minimum of a dense sampling, refined by ternary search: nothing shared with the index.
double exhaustive(const PiecewiseCubic& curve, const Vec2& p) {
    constexpr int steps = 40;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < curve.spans(); ++k) {
        const double from = curve.breaks()[k], h = (curve.breaks()[k + 1] - from) / steps;
        const auto squared = [&](double t) { return (curve.jet_in(k, t).position - p).squaredNorm(); };
        double before = std::numeric_limits<double>::infinity(), here = squared(from);
        for (int i = 0; i <= steps; ++i) {
            const double t = from + i * h;
            const double after = i < steps ? squared(t + h) : std::numeric_limits<double>::infinity();
            if (here <= before && here <= after) {
                double low = std::max(from, t - h), high = std::min(from + steps * h, t + h);
                for (int round = 0; round < 60; ++round) {
                    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
                    (squared(a) < squared(b) ? high : low) = squared(a) < squared(b) ? b : a;
                }
                best = std::min(best, squared(0.5 * (low + high)));
            }
            before = here;
            here = after;
        }
        best = std::min({best, squared(from), squared(from + steps * h)});
    }
    return std::sqrt(best);
}

std::vector<Vec2> asked_points(const PiecewiseCubic& curve) {
    core::Rng rng(11);
    std::vector<Vec2> points;
    for (int i = 0; i < 400; ++i) {
        const Jet jet = curve.jet(curve.period() * rng.uniform());
        const Vec2 n = jet.right_normal();
        points.push_back(jet.position + rng.uniform(-0.02, 0.02) * n);  // as measured
        points.push_back(jet.position + rng.uniform(-4.0, 6.0) * n);    // also through the blade
        points.push_back(jet.position + rng.uniform(20.0, 500.0) * n);  // far
        points.push_back(jet.position - n / jet.curvature());           // centre of curvature: flat minimum
        points.emplace_back(rng.uniform(-45.0, 45.0), rng.uniform(-15.0, 25.0));
        const double x = rng.uniform(-30.0, 30.0);
        points.emplace_back(x, 8.0 * x * x / 900.0);  // the medial axis
    }
    for (const double t : curve.breaks())
        points.push_back(curve.jet(t).position);
    return points;
}

TEST(ClosestPointIndex, NoPointIsOffByANanometre) {
    const PiecewiseCubic curve = thin_blade();
    const ClosestPointIndex index(curve);
    for (const Vec2& p : asked_points(curve)) {
        const CurveFoot foot = index.closest(p);
        EXPECT_NEAR((curve.jet_in(foot.span, foot.t).position - p).norm(), std::sqrt(foot.squared), 1e-12);
        EXPECT_LT(std::sqrt(foot.squared) - exhaustive(curve, p), nanometre) << p.transpose();
    }
}

TEST(ClosestPointIndex, AnyHintGivesTheSameDistance) {
    const PiecewiseCubic curve = thin_blade();
    const ClosestPointIndex index(curve);
    core::Rng rng(2);
    for (const Vec2& p : asked_points(curve)) {
        const double expected = index.closest(p).squared;
        const auto hint = static_cast<std::size_t>(rng.uniform(0.0, 130.0));
        EXPECT_NEAR(std::sqrt(index.closest(p, hint).squared), std::sqrt(expected), 1e-10);
    }
}

TEST(ClosestPointIndex, FlatMinimaAndLoops) {
    std::vector<Vec2> circle, eight;
    for (int i = 0; i < 30; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 30.0;
        circle.emplace_back(3.0 * std::cos(a), 3.0 * std::sin(a));
        eight.emplace_back(5.0 * std::sin(a), 2.0 * std::sin(2.0 * a));
    }
    for (const auto& points : {circle, eight}) {
        const PiecewiseCubic curve = interpolate_periodic(points, chord_parameters(points, true));
        const ClosestPointIndex index(curve);
        core::Rng rng(3);
        for (int i = 0; i < 200; ++i) {
            const Vec2 p = i == 0 ? Vec2(0, 0) : Vec2(rng.uniform(-8, 8), rng.uniform(-4, 4));
            EXPECT_LT(std::sqrt(index.closest(p).squared) - exhaustive(curve, p), nanometre) << p.transpose();
        }
    }
}

TEST(ClosestPointIndex, SingleSpansThatBendMuch) {
    core::Rng rng(8);
    for (int k = 0; k < 200; ++k) {
        PiecewiseCubic::Piece piece;
        for (Vec2& c : piece)
            c = {rng.uniform(-3, 3), rng.uniform(-3, 3)};
        const PiecewiseCubic curve({0.5, 1.5}, {piece}, false);
        const ClosestPointIndex index(curve);
        for (int i = 0; i < 20; ++i) {
            const Vec2 p(rng.uniform(-4, 4), rng.uniform(-4, 4));
            EXPECT_LT(std::sqrt(index.closest(p).squared) - exhaustive(curve, p), nanometre);
        }
    }
}

TEST(ClosestPointIndex, PointsThatAreNotFinite) {
    const ClosestPointIndex index(thin_blade());
    constexpr double inf = std::numeric_limits<double>::infinity();
    for (const Vec2& p : {Vec2(std::nan(""), 0), Vec2(0, inf), Vec2(-inf, inf), Vec2(1e200, 0)}) {
        const CurveFoot foot = index.closest(p);
        EXPECT_EQ(foot.span, 0U);
        EXPECT_EQ(foot.squared, inf);
    }
    EXPECT_NEAR(std::sqrt(index.closest({1e140, 0}).squared), 1e140, 1e125);
}

TEST(ClosedCurve, ABatchGivesWhatSinglePointsGiveInAnyOrder) {
    const ClosedCurve curve(thin_blade());
    std::vector<Vec2> points;
    for (int round = 0; round < 2; ++round)
        for (const Vec2& p : asked_points(curve.spline()))
            points.push_back(p);
    points.emplace_back(std::nan(""), 1.0);
    std::mt19937_64 order(1);
    for (int round = 0; round < 2; ++round) {
        std::vector<ClosestPoint> feet(points.size());
        curve.closest(points, feet);
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (!is_finite(points[i])) {
                EXPECT_TRUE(std::isnan(feet[i].distance_mm));
                continue;
            }
            const ClosestPoint single = curve.closest(points[i]);
            EXPECT_NEAR(std::abs(feet[i].distance_mm), std::abs(single.distance_mm), 1e-10);
            EXPECT_LT((curve.position(feet[i].s_mm) - feet[i].foot).norm(), 1e-9);
            EXPECT_NEAR((points[i] - feet[i].foot).norm(), std::abs(feet[i].distance_mm), 1e-10);
        }
        std::shuffle(points.begin(), points.end(), order);
    }
}

/// A nominal of thousands of spans is compared with points that lie many spans apart, one after another: the search
/// that goes along with them must give the nearest of all, also where they jump.
TEST(ClosedCurve, ABatchAlongAndAcrossManyShortSpans) {
    std::vector<Vec2> dense;
    const PiecewiseCubic blade = thin_blade();
    for (int i = 0; i < 6000; ++i)
        dense.push_back(blade.jet(blade.front() + blade.period() * i / 6000.0).position);
    const ClosedCurve curve(interpolate_periodic(dense, chord_parameters(dense, true)));
    core::Rng rng(3);
    std::vector<Vec2> points;
    for (int i = 0; i < 2400; ++i) {
        const bool jumps = i % 300 > 290;
        const auto at = curve.evaluate(curve.length() * (jumps ? rng.uniform() : i / 2400.0));
        points.push_back(at.position + (jumps ? rng.uniform(-2.0, 2.0) : 2e-3 * rng.normal()) * at.normal);
    }
    std::vector<ClosestPoint> feet(points.size());
    curve.closest(points, feet);
    for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_NEAR(std::abs(feet[i].distance_mm), std::abs(curve.closest(points[i]).distance_mm), 1e-10);
        const auto at = curve.evaluate(feet[i].s_mm);
        EXPECT_LT((at.position - feet[i].foot).norm() + (at.normal - feet[i].normal).norm(), 1e-8);
        // From a foot beside it the same one is found.
        const auto again = curve.closest(points[i], feet[i].place);
        EXPECT_NEAR(again.distance_mm, feet[i].distance_mm, 1e-10);
    }
}

}  // namespace
}  // namespace cmm::fitting
