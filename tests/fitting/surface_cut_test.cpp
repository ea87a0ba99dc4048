// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_cut.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/surfaces.hpp"

namespace cmm::fitting {
namespace {

constexpr double full_turn = 2 * std::numbers::pi;

/// A cone of 8 mm radius at z = 0 that narrows by 0.4 mm a millimetre; v is not the height.
Surface cone() {
    return spline_of(
        [](double u, double v) {
            const double z = v + 0.02 * v * v + 0.2 * std::sin(u), r = 8 - 0.4 * z;
            return Vec3(r * std::cos(u), r * std::sin(u), z);
        },
        full_turn, 600, true, 10, 40);
}

TEST(SurfaceCut, OfAConeIsACircle) {
    const Surface surface = cone();
    const auto cut = cut_at_height(surface, 0.0, 4.0, span_parameters(surface.u(), 3));
    ASSERT_TRUE(cut) << cut.error().message;
    ASSERT_EQ(cut->points.size(), 1800U);
    for (const CutPoint& p : cut->points) {
        EXPECT_NEAR(p.position.z(), 4.0, 1e-11);
        EXPECT_NEAR(p.position.head<2>().norm(), 8 - 0.4 * 4, 1e-8);
        EXPECT_NEAR(p.normal.z(), 0.4 / std::hypot(1, 0.4), 1e-6);
    }
}

TEST(SurfaceCut, OfAnOffsetConeIsTheOffsetCircle) {
    const Surface surface = cone();
    for (const double d : {-1.0, 0.5}) {
        const auto cut = cut_at_height(surface, d, 4.0, span_parameters(surface.u(), 2));
        ASSERT_TRUE(cut) << cut.error().message;
        EXPECT_EQ(cut->folded, 0U);
        for (const CutPoint& p : cut->points)
            EXPECT_NEAR(p.position.head<2>().norm(), 8 - 0.4 * 4 + d * std::hypot(1, 0.4), 1e-7);
    }
}

TEST(SurfaceCut, WherePlanesMissOrBallsDoNotReach) {
    const Surface surface = cone();
    EXPECT_FALSE(cut_at_height(surface, 0.0, -1.0, span_parameters(surface.u(), 1)));
    EXPECT_FALSE(cut_at_height(surface, 0.0, 50.0, span_parameters(surface.u(), 1)));
    const Surface groove =
        spline_of([](double u, double v) { return Vec3(u, 2 * std::cos(u), v); }, full_turn, 200, false, 4, 4);
    const auto cut = cut_at_height(groove, -1.0, 2.0, span_parameters(groove.u(), 1));
    ASSERT_TRUE(cut);
    EXPECT_GT(cut->folded, 5U) << "radius of curvature 0.5 mm on one side";
    EXPECT_LT(cut->folded, 100U);
    EXPECT_EQ(cut->points.size(), 201U);
    EXPECT_EQ(std::count_if(cut->points.begin(), cut->points.end(), [](const CutPoint& p) { return p.folded; }),
              std::ptrdiff_t(cut->folded));
}

}  // namespace
}  // namespace cmm::fitting
