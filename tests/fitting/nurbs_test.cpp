// SPDX-License-Identifier: Apache-2.0
#include "fitting/nurbs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/recursion.hpp"

namespace cmm::fitting {
namespace {

const std::vector<Vec2> points{{0, 0}, {1, 2}, {3, 2.5}, {4, 1}, {6, 0.5}, {7, 2}};
const std::vector<double> weights{1.0, 1.3, 0.8, 1.2, 0.9, 1.0};

struct Ends {
    NurbsEnd nurbs;
    SplineEnd spline;
};
/// The same end condition of both; the spline's parameter runs over the chord length.
std::vector<Ends> all_ends() {
    const Vec2 tangent(1, 3);
    return {{NurbsEnd(), SplineEnd()},
            {NurbsEnd::along(tangent), SplineEnd::derivative(tangent.normalized())},
            {NurbsEnd::not_a_knot(), SplineEnd::not_a_knot()}};
}

/// seeds-spec A18: with all data weights 1 the control weights are 1 and the curve is the non-rational C2 spline.
TEST(Nurbs, UnitWeightsGiveTheNonRationalSplineWithEveryEnd) {
    const auto t = chord_parameters(points, false);
    for (const Ends& start : all_ends())
        for (const Ends& end : all_ends())
            for (const double w : {1.0, 3.0}) {
                const auto curve =
                    interpolate_nurbs(points, std::vector<double>(points.size(), w), start.nurbs, end.nurbs);
                ASSERT_TRUE(curve);
                for (const double weight : curve->weights())
                    EXPECT_NEAR(weight, w, 1e-13);
                const auto spline = interpolate_open(points, t, start.spline, end.spline);
                for (int k = 0; k <= 200; ++k) {
                    const double u = k / 200.0;
                    const Jet rational = curve->jet(u), plain = spline.jet(u * t.back());
                    EXPECT_LT((rational.position - plain.position).norm(), 1e-12);
                    EXPECT_LT((rational.d1 - t.back() * plain.d1).norm(), 1e-10);
                    EXPECT_LT((rational.d2 - t.back() * t.back() * plain.d2).norm(), 1e-8);
                }
            }
}

TEST(Nurbs, UnitWeightsGiveThePeriodicSpline) {
    const auto curve = interpolate_closed_nurbs(points, {});
    ASSERT_TRUE(curve);
    const auto t = chord_parameters(points, true);
    const auto spline = interpolate_periodic(points, t);
    for (const double weight : curve->weights())
        EXPECT_NEAR(weight, 1.0, 1e-13);
    for (int k = 0; k <= 200; ++k)
        EXPECT_LT((curve->position(k / 200.0) - spline.jet(k / 200.0 * t.back()).position).norm(), 1e-12);
}

/// The equations of the paper, written out with the recursion (seeds-spec A15-A19, corrected).
TEST(Nurbs, FulfilsEquationsNineToFourteen) {
    const Vec2 start(1, 3), end(2, -1);
    const double slope = 0.4;
    const auto curve = interpolate_nurbs(points, weights, NurbsEnd::along(start, slope), NurbsEnd::along(end));
    ASSERT_TRUE(curve);
    const auto& u = curve->knots();
    const auto d = curve->controls();
    const auto w = curve->weights();
    const std::size_t n = points.size();
    ASSERT_EQ(u.size(), n + 6);
    ASSERT_EQ(d.size(), n + 2);
    const double chords = chord_parameters(points, false).back();
    for (std::size_t i = 0; i + 1 < n; ++i) {  // the last parameter lies outside the half-open spans
        EXPECT_NEAR(u[i + 3], chord_parameters(points, false)[i] / chords, 1e-15);  // (8)
        double weight = 0.0;
        Vec2 weighted = Vec2::Zero();
        for (std::size_t j = 0; j < d.size(); ++j) {
            weight += w[j] * truth::basis(u, j, 3, u[i + 3]);
            weighted += w[j] * d[j] * truth::basis(u, j, 3, u[i + 3]);
        }
        EXPECT_NEAR(weight, weights[i], 1e-13);                    // (9)
        EXPECT_LT((weighted / weight - points[i]).norm(), 1e-13);  // (12)
        EXPECT_LT((curve->position(u[i + 3]) - points[i]).norm(), 1e-13);
    }
    EXPECT_NEAR(3.0 * (w[1] - w[0]) / (u[4] - u[3]), slope, 1e-12);                          // (10)
    EXPECT_NEAR(3.0 * (w[n + 1] - w[n]) / (u[n + 2] - u[n + 1]), 0.0, 1e-12);                // (11)
    const Vec2 q_start = 3.0 * w[1] * (d[1] - d[0]) / (w[0] * (u[4] - u[3]));                // (13)
    const Vec2 q_end = 3.0 * w[n] * (d[n + 1] - d[n]) / (w[n + 1] * (u[n + 2] - u[n + 1]));  // (14)
    EXPECT_LT((q_start - chords * start.normalized()).norm(), 1e-11);
    EXPECT_LT((q_end - chords * end.normalized()).norm(), 1e-11);
    EXPECT_LT((curve->jet(0.0).d1 - q_start).norm(), 1e-11);
    EXPECT_LT((curve->jet(1.0).d1 - q_end).norm(), 1e-11);
    const auto plain = interpolate_nurbs(points, {}, NurbsEnd::along(start), NurbsEnd::along(end));
    EXPECT_GT((curve->position(0.3) - plain->position(0.3)).norm(), 1e-4) << "weights must matter";
}

TEST(Nurbs, TheClosedOneIsSmoothAtItsSeam) {
    const auto curve = interpolate_closed_nurbs(points, weights);
    ASSERT_TRUE(curve);
    const auto t = chord_parameters(points, true);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT((curve->position(t[i] / t.back()) - points[i]).norm(), 1e-12);
    const Jet before = curve->jet(1.0 - 1e-9), after = curve->jet(0.0);
    EXPECT_LT((before.d1 - after.d1).norm(), 1e-5);
    EXPECT_LT((before.d2 - after.d2).norm(), 1e-3);
}

/// A quarter circle is a quadratic NURBS with the middle weight cos 45 degrees: derivatives against the truth.
TEST(Nurbs, AQuarterCircleIsOne) {
    const double w = std::sqrt(0.5);
    auto homogeneous = BSpline<3>::make(2, {0, 0, 0, 1, 1, 1}, {{1, 0, 1}, {w, w, w}, {0, 1, 1}}, false);
    const auto curve = NurbsCurve::make(homogeneous.value());
    ASSERT_TRUE(curve);
    const auto finer = curve->with_knot(0.3);
    ASSERT_TRUE(finer);
    for (int k = 0; k <= 50; ++k) {
        const Jet jet = curve->jet(k / 50.0);
        EXPECT_NEAR(jet.position.norm(), 1.0, 1e-14);
        EXPECT_NEAR(jet.curvature(), 1.0, 1e-12);
        EXPECT_LT((jet.position - curve->position(k / 50.0)).norm(), 1e-15);
        EXPECT_LT((finer->position(k / 50.0) - jet.position).norm(), 1e-14);
    }
    const auto back = finer->reduced(1e-9);
    EXPECT_EQ(back.curve.controls().size(), 3U);
    EXPECT_LE(back.error_mm, 1e-9);
}

TEST(Nurbs, RemovalKeepsItsBound) {
    std::vector<Vec2> many;
    std::vector<double> heavy;
    for (int i = 0; i < 80; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 80.0;
        many.emplace_back(5.0 * std::cos(a), 2.0 * std::sin(a));
        heavy.push_back(1.0 + 0.3 * std::sin(3.0 * a));
    }
    const auto curve = interpolate_closed_nurbs(many, heavy);
    ASSERT_TRUE(curve);
    for (const double tolerance : {0.0, 1e-4, 1e-2}) {
        const auto coarser = curve->reduced(tolerance);
        EXPECT_LE(coarser.error_mm, tolerance);
        double worst = 0.0;
        for (int k = 0; k < 1000; ++k)
            worst = std::max(worst, (coarser.curve.position(k / 1000.0) - curve->position(k / 1000.0)).norm());
        EXPECT_LE(worst, coarser.error_mm + 1e-13);
        if (tolerance > 1e-3) {
            EXPECT_LT(coarser.curve.controls().size(), 70U);
        }
    }
}

TEST(Nurbs, TwoPointsGiveALine) {
    const auto curve = interpolate_nurbs(std::vector<Vec2>{{1, 1}, {3, 5}}, {}, {}, NurbsEnd::not_a_knot());
    ASSERT_TRUE(curve);
    EXPECT_LT((curve->position(0.25) - Vec2(1.5, 2.0)).norm(), 1e-13);
}

TEST(Nurbs, RefusesBrokenInput) {
    const NurbsEnd free;
    EXPECT_FALSE(interpolate_nurbs(std::vector<Vec2>{{1, 1}}, {}, free, free));
    EXPECT_FALSE(interpolate_nurbs(std::vector<Vec2>{{1, 1}, {1, 1}, {2, 2}}, {}, free, free));
    EXPECT_FALSE(interpolate_nurbs(std::vector<Vec2>{{-1e12, 2}, {1e9, 1}, {1e9 + 1e-6, 1}}, {}, free, free))
        << "a chord that vanishes beside the whole";
    EXPECT_FALSE(interpolate_nurbs(std::vector<Vec2>{{1, 1}, {std::nan(""), 1}}, {}, free, free));
    EXPECT_FALSE(interpolate_nurbs(points, std::vector<double>{1, 1}, free, free));
    EXPECT_FALSE(interpolate_nurbs(points, std::vector<double>{1, 1, 0, 1, 1, 1}, free, free));
    EXPECT_FALSE(interpolate_nurbs(points, std::vector<double>{1, 1, 1e9, 1, 1e9, 1}, free, free))
        << "control weights below zero";
    EXPECT_FALSE(interpolate_nurbs(points, {}, NurbsEnd::along({0, 0}), free));
    EXPECT_FALSE(interpolate_closed_nurbs(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}}, {}));
    EXPECT_FALSE(interpolate_closed_nurbs(std::vector<Vec2>{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}, {}))
        << "the last point repeats the first";
}

}  // namespace
}  // namespace cmm::fitting
