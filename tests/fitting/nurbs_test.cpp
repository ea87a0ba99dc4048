// SPDX-License-Identifier: Apache-2.0
#include "fitting/nurbs.hpp"

#include <gtest/gtest.h>

namespace cmm::fitting {
namespace {

const std::vector<Vec2> points{{0, 0}, {1, 2}, {3, 2.5}, {4, 1}, {6, 0.5}, {7, 2}};

/// seeds-spec A18: with all data weights 1 the control weights are 1 and the curve is the non-rational C2 spline.
TEST(Nurbs, UnitWeightsGiveTheNonRationalSpline) {
    const Vec2 start(1, 1), end(0, 1);
    const auto curve = interpolate_nurbs(points, std::vector<double>(points.size(), 1.0), {start, end});
    ASSERT_TRUE(curve);
    for (const double w : curve->weights())
        EXPECT_NEAR(w, 1.0, 1e-13);
    const auto t = chord_parameters(points, false);
    const auto spline = interpolate_open(points, t, start.normalized(), end.normalized());
    for (int k = 0; k <= 200; ++k) {
        const double u = k / 200.0;
        EXPECT_LT((curve->position(u) - spline.jet(u * t.back()).position).norm(), 1e-12);
        EXPECT_LT((curve->derivative(u) - t.back() * spline.jet(u * t.back()).d1).norm(), 1e-10);
    }
}

TEST(Nurbs, NaturalEndsGiveTheNaturalSpline) {
    const auto curve = interpolate_nurbs(points, {}, {});
    ASSERT_TRUE(curve);
    const auto t = chord_parameters(points, false);
    const auto spline = interpolate_open(points, t);
    for (int k = 0; k <= 200; ++k)
        EXPECT_LT((curve->position(k / 200.0) - spline.jet(k / 200.0 * t.back()).position).norm(), 1e-12);
}

TEST(Nurbs, RationalCurveGoesThroughPointsAndKeepsEndTangents) {
    const std::vector<double> weights{1.0, 1.3, 0.8, 1.2, 0.9, 1.0};
    const Vec2 start(1, 3), end(2, -1);
    const auto curve = interpolate_nurbs(points, weights, {start, end});
    ASSERT_TRUE(curve);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_LT((curve->position(curve->knots()[i + 3]) - points[i]).norm(), 1e-12);
    EXPECT_LT((curve->derivative(0.0).normalized() - start.normalized()).norm(), 1e-12);
    EXPECT_LT((curve->derivative(1.0).normalized() - end.normalized()).norm(), 1e-12);
    const auto plain = interpolate_nurbs(points, {}, {start, end});
    EXPECT_GT((curve->position(0.3) - plain->position(0.3)).norm(), 1e-4) << "weights must matter";
    for (const double u : curve->knots()) {
        if (u <= 0.0 || u >= 1.0) continue;
        EXPECT_LT((curve->derivative(u + 1e-8) - curve->derivative(u - 1e-8)).norm(), 1e-4);
    }
}

TEST(Nurbs, KnotsFollowTheChordsThatExist) {
    const auto curve = interpolate_nurbs(points, {}, {});
    ASSERT_TRUE(curve);
    EXPECT_EQ(curve->knots().size(), points.size() + 6);
    EXPECT_EQ(curve->controls().size(), points.size() + 2);
    EXPECT_DOUBLE_EQ(curve->knots()[points.size() + 2], 1.0);
}

TEST(Nurbs, TwoPointsGiveALine) {
    const auto curve = interpolate_nurbs(std::vector<Vec2>{{1, 1}, {3, 5}}, {}, {});
    ASSERT_TRUE(curve);
    EXPECT_LT((curve->position(0.25) - Vec2(1.5, 2.0)).norm(), 1e-13);
}

TEST(Nurbs, RefusesBrokenInput) {
    EXPECT_FALSE(interpolate_nurbs(std::vector<Vec2>{{1, 1}}, {}, {}));
    EXPECT_FALSE(interpolate_nurbs(std::vector<Vec2>{{1, 1}, {1, 1}, {2, 2}}, {}, {}));
    EXPECT_FALSE(interpolate_nurbs(points, std::vector<double>{1, 1}, {}));
    EXPECT_FALSE(interpolate_nurbs(points, std::vector<double>{1, 1, 0, 1, 1, 1}, {}));
}

}  // namespace
}  // namespace cmm::fitting
