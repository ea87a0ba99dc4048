// SPDX-License-Identifier: Apache-2.0
#include "fitting/join.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace cmm::fitting {
namespace {

/// A circle of radius 2 whose spline is pushed 1 um outwards by a ripple; the patch knows the true circle.
TEST(Join, ReplacesThePatchAndKeepsTheRest) {
    std::vector<Vec2> points;
    for (int i = 0; i < 200; ++i) {
        const double a = i * std::numbers::pi / 100;
        points.push_back((2.0 + 0.001 * std::sin(20 * a)) * Vec2(std::cos(a), std::sin(a)));
    }
    const auto curve = interpolate_periodic(points, chord_parameters(points, true));
    ArcPatch patch;
    patch.circle.radius = 2.0;
    patch.from = curve.period() - 1.0;  // over the period's end
    patch.to = curve.period() + 2.0;
    const auto joined = join_arcs(curve, std::vector<ArcPatch>{patch});
    ASSERT_NEAR(joined.period(), curve.period(), 1e-12);
    for (double t = -0.2; t < 1.2; t += 0.01)
        EXPECT_NEAR(joined.jet(t).position.norm(), 2.0, 2e-6) << t;
    for (double t = 2.2; t < curve.period() - 1.2; t += 0.01)
        EXPECT_LT((joined.jet(t).position - curve.jet(t).position).norm(), 1e-6) << t;
    double farthest = 0.0;
    for (double t = 0.0; t < curve.period(); t += 0.001)
        farthest = std::max(farthest, std::abs(joined.jet(t).position.norm() - 2.0));
    EXPECT_LT(farthest, 1.1e-3) << "no join leaves the two curves";
}

TEST(Join, WithoutPatchesNothingChanges) {
    const std::vector<Vec2> points{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
    const auto curve = interpolate_periodic(points, chord_parameters(points, true));
    EXPECT_EQ(join_arcs(curve, {}).breaks(), curve.breaks());
}

}  // namespace
}  // namespace cmm::fitting
