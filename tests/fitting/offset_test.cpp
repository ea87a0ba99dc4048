// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace cmm::fitting {
namespace {

std::vector<Vec2> ellipse(double a, double b) {
    std::vector<Vec2> points;
    for (int i = 0; i < 400; ++i)
        points.emplace_back(a * std::cos(i * std::numbers::pi / 200), b * std::sin(i * std::numbers::pi / 200));
    return points;
}

double signed_area(const std::vector<OffsetPoint>& points) {
    double twice = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
        twice += cross(points[i].position, points[(i + 1) % points.size()].position);
    return 0.5 * twice;
}

TEST(Offset, IsParallelAndCounterClockwise) {
    const auto curve = ClosedCurve::through(ellipse(6, 4));
    ASSERT_TRUE(curve);
    const auto offset = offset_inwards(*curve, 0.8, 1000);
    EXPECT_EQ(offset.trimmed, 0U);
    EXPECT_GE(offset.points.size(), 1000U);
    for (const auto& p : offset.points) {
        EXPECT_NEAR(curve->closest(p.position).distance_mm, -0.8, 1e-9);
        EXPECT_NEAR(p.normal.norm(), 1.0, 1e-12);
    }
    // Steiner: A' = A - L r + pi r^2 for a convex curve without loops
    EXPECT_NEAR(signed_area(offset.points), curve->area() - curve->length() * 0.8 + std::numbers::pi * 0.64, 1e-3);
}

/// A24: where the radius exceeds the radius of curvature (b^2/a = 0.67 at the tips) the offset loops; the loops are
/// cut.
TEST(Offset, LoopsAreTrimmedWhereTheyArise) {
    const auto curve = ClosedCurve::through(ellipse(6, 2));
    ASSERT_TRUE(curve);
    const auto offset = offset_inwards(*curve, 1.2, 2000);
    EXPECT_GT(offset.trimmed, 0U);
    ASSERT_GT(offset.points.size(), 500U);
    for (const auto& p : offset.points)
        EXPECT_NEAR(curve->closest(p.position).distance_mm, -1.2, 1e-5);
    for (std::size_t i = 0; i < offset.points.size(); ++i) {
        const auto &a = offset.points[i], &b = offset.points[(i + 1) % offset.points.size()];
        const Vec2 normal = a.normal + b.normal;
        EXPECT_GT((b.position - a.position).dot(Vec2(-normal.y(), normal.x())), 0.0) << "runs backwards at " << i;
    }
}

}  // namespace
}  // namespace cmm::fitting
