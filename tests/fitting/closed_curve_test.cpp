// SPDX-License-Identifier: Apache-2.0
#include "fitting/closed_curve.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

std::vector<Vec2> ellipse(std::size_t n, double a, double b) {
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = 2.0 * pi * static_cast<double>(i) / static_cast<double>(n);
        points.emplace_back(a * std::cos(t), b * std::sin(t));
    }
    return points;
}

TEST(ClosedCurve, LengthAreaAndCurvatureOfACircle) {
    const auto curve = ClosedCurve::through(ellipse(200, 3.0, 3.0));
    ASSERT_TRUE(curve);
    EXPECT_NEAR(curve->length(), 6.0 * pi, 1e-6);
    EXPECT_NEAR(curve->area(), 9.0 * pi, 1e-6);
    const auto p = curve->evaluate(2.0);
    EXPECT_NEAR(p.curvature, 1.0 / 3.0, 1e-4);
    EXPECT_NEAR(p.position.x(), 3.0 * std::cos(2.0 / 3.0), 1e-6);
    EXPECT_NEAR(p.normal.dot(p.position.normalized()), 1.0, 1e-9);
}

TEST(ClosedCurve, ArcLengthIsTrueArcLength) {
    const auto curve = ClosedCurve::through(ellipse(60, 10.0, 1.0));
    ASSERT_TRUE(curve);
    double walked = 0.0;
    Vec2 last = curve->position(0.0);
    for (int k = 1; k <= 40000; ++k) {
        const double s = curve->length() * k / 40000.0;
        const Vec2 here = curve->position(s);
        walked += (here - last).norm();
        last = here;
        if (k % 4000 == 0) {
            EXPECT_NEAR(walked, s, 2e-6);
        }
    }
    EXPECT_NEAR(curve->arc_length_at(curve->parameter_at(7.0)), 7.0, 1e-9);
}

TEST(ClosedCurve, NormalisesDirectionAndRepeatedPoints) {
    auto points = ellipse(50, 4.0, 2.0);
    const auto straight = ClosedCurve::through(points);
    std::reverse(points.begin() + 1, points.end());
    points.insert(points.begin() + 7, points[7]);
    points.push_back(points.front());
    const auto reversed = ClosedCurve::through(points);
    ASSERT_TRUE(straight && reversed);
    EXPECT_FALSE(straight->was_clockwise());
    EXPECT_TRUE(reversed->was_clockwise());
    EXPECT_NEAR(straight->length(), reversed->length(), 1e-10);
    EXPECT_LT((straight->position(3.0) - reversed->position(3.0)).norm(), 1e-10);
}

TEST(ClosedCurve, ClosestAgreesWithADenseSearch) {
    const auto curve = ClosedCurve::through(ellipse(80, 10.0, 0.5));
    ASSERT_TRUE(curve);
    core::Rng rng(5);
    for (int k = 0; k < 300; ++k) {
        const Vec2 p(rng.uniform(-12, 12), rng.uniform(-2, 2));
        double best = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 20000; ++i)
            best = std::min(best, (curve->position(curve->length() * i / 20000.0) - p).norm());
        const auto found = curve->closest(p);
        EXPECT_LE(std::abs(found.distance_mm), best + 1e-12);
        EXPECT_NEAR(std::abs(found.distance_mm), best, 1e-4);
        EXPECT_LT((curve->position(found.s_mm) - found.foot).norm(), 1e-7);
        EXPECT_EQ(found.distance_mm > 0.0, p.x() * p.x() / 100.0 + p.y() * p.y() / 0.25 > 1.0);
    }
}

TEST(ClosedCurve, AHintFollowsTheNeighbouringFoot) {
    const auto curve = ClosedCurve::through(ellipse(400, 20.0, 1.0));
    ASSERT_TRUE(curve);
    double hint = 0.0;
    for (double s = 0.0; s < curve->length(); s += 0.1) {
        const auto at = curve->evaluate(s);
        const auto found = curve->closest(at.position + 0.3 * at.normal, hint);
        EXPECT_NEAR(found.s_mm, s, 1e-6);
        EXPECT_NEAR(found.distance_mm, 0.3, 1e-9);
        hint = found.s_mm;
    }
}

TEST(ClosedCurve, OffsetPointsLieAtTheDistance) {
    const auto curve = ClosedCurve::through(ellipse(100, 5.0, 3.0));
    ASSERT_TRUE(curve);
    for (const Vec2& p : curve->offset_points(0.7, 0.05))
        EXPECT_NEAR(curve->closest(p).distance_mm, 0.7, 1e-9);
}

TEST(ClosedCurve, RefusesWhatIsNoCurve) {
    EXPECT_FALSE(ClosedCurve::through({}));
    EXPECT_FALSE(ClosedCurve::through(std::vector<Vec2>(20, Vec2(1, 1))));
    EXPECT_FALSE(ClosedCurve::through(std::vector<Vec2>{{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}}));
    auto points = ellipse(20, 1.0, 1.0);
    points[7].x() = std::nan("");
    const auto refused = ClosedCurve::through(points);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("point 7"), std::string::npos);
}

}  // namespace
}  // namespace cmm::fitting
