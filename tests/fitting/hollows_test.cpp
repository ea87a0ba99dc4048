// SPDX-License-Identifier: Apache-2.0
#include "fitting/hollows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/shapes.hpp"

namespace cmm::fitting {
namespace {

using truth::ellipse, truth::polygon;

/// An L: the ball of radius r rests on both flanks of the corner at a distance of r; gap r (sqrt 2 - 1).
TEST(Hollows, AStepIsBridgedByTheBall) {
    const auto part = polygon({{0, 0}, {10, 0}, {10, 3}, {3, 3}, {3, 8}, {0, 8}});
    for (const double r : {0.25, 1.0, 2.0}) {
        const auto hollows = find_hollows(part, r);
        ASSERT_EQ(hollows.size(), 1U);
        const Hollow& hollow = hollows[0];
        EXPECT_NEAR((hollow.centre - Vec2(3 + r, 3 + r)).norm(), 0.0, 1e-12);
        EXPECT_NEAR((hollow.begin - Vec2(3 + r, 3)).norm(), 0.0, 1e-9);
        EXPECT_NEAR((hollow.end - Vec2(3, 3 + r)).norm(), 0.0, 1e-9);
        EXPECT_NEAR(hollow.depth_mm, r * (std::numbers::sqrt2 - 1.0), 1e-9);
        const Vec2 on_ball = hollow.centre - r * Vec2(1, 1).normalized();
        EXPECT_TRUE(hollow.bridges(on_ball, Vec2(1, 1).normalized()));
        EXPECT_TRUE(hollow.bridges(on_ball - Vec2(0.05, 0.02), Vec2(1, 1).normalized()));
        EXPECT_FALSE(hollow.bridges(on_ball, Vec2(-1, -1).normalized())) << "the other side of a thin part";
        EXPECT_FALSE(hollow.bridges({3 + 1.01 * r, 3.0}, {0, 1}));
        EXPECT_TRUE(hollow.bridges({3 + 0.99 * r, 3.0}, {0, 1}));
        EXPECT_FALSE(hollow.bridges({3.0, 3 + 1.01 * r}, {1, 0}));
        EXPECT_TRUE(hollow.bridges({3.0, 3 + 0.99 * r}, {1, 0}));
    }
    EXPECT_TRUE(find_hollows(part, 0.0).empty());
    EXPECT_TRUE(find_hollows(part, 0.25, 0.2).empty()) << "shallower than asked for";
}

/// A groove narrower than the ball: it rests on the two rims, sqrt(r^2 - w^2/4) above them.
TEST(Hollows, AGrooveIsBridgedFromRimToRim) {
    const auto part = polygon({{0, 0}, {10, 0}, {10, 5}, {6, 5}, {6, 2}, {5, 2}, {5, 5}, {0, 5}});
    const auto hollows = find_hollows(part, 1.0);
    ASSERT_EQ(hollows.size(), 1U);
    EXPECT_NEAR((hollows[0].centre - Vec2(5.5, 5 + std::sqrt(0.75))).norm(), 0.0, 1e-9);
    EXPECT_NEAR((hollows[0].begin - Vec2(6, 5)).norm(), 0.0, 1e-9);
    EXPECT_NEAR((hollows[0].end - Vec2(5, 5)).norm(), 0.0, 1e-9);
    EXPECT_NEAR(hollows[0].depth_mm, std::hypot(0.5, 3 + std::sqrt(0.75)) - 1.0, 1e-9);
}

TEST(Hollows, AConvexPartHasNone) {
    EXPECT_TRUE(find_hollows(ellipse(30, 3, 200), 5.0).empty());
}

TEST(Hollows, OneThatCoversTheStartHoldsBothEnds) {
    const auto part = polygon({{3, 3}, {3, 8}, {0, 8}, {0, 0}, {10, 0}, {10, 3}});
    const auto hollows = find_hollows(part, 1.0);
    ASSERT_EQ(hollows.size(), 1U);
    EXPECT_GT(hollows[0].from, hollows[0].to);
    EXPECT_TRUE(hollows[0].holds(0.0) && hollows[0].holds(0.5) && hollows[0].holds(part.period() - 0.5));
    EXPECT_FALSE(hollows[0].holds(1.5) || hollows[0].holds(part.period() - 1.5));
    EXPECT_NEAR(hollows[0].depth_mm, std::numbers::sqrt2 - 1.0, 1e-9);
}

}  // namespace
}  // namespace cmm::fitting
