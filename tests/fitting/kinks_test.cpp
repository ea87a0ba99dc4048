// SPDX-License-Identifier: Apache-2.0
#include "fitting/kinks.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "fitting/outliers.hpp"

namespace cmm::fitting {
namespace {

const std::vector<Vec2> before{{-0.4, 0.0}, {-0.8, 0.0}, {-1.2, 0.0}, {-1.6, 0.0}};
const std::vector<Vec2> after{{0.4, 0.2}, {0.8, 0.4}, {1.2, 0.6}, {1.6, 0.8}};

TEST(Kinks, CornerPointsContinueASide) {
    EXPECT_TRUE(continues_a_side(std::vector<Vec2>{{0.0, 0.001}}, before, after, 0.006));
    EXPECT_TRUE(continues_a_side(std::vector<Vec2>{{-0.1, 0.0}, {0.1, 0.05}}, before, after, 0.006));
    EXPECT_FALSE(continues_a_side(std::vector<Vec2>{{0.0, -0.05}}, before, after, 0.006)) << "neither side";
    EXPECT_FALSE(continues_a_side(std::vector<Vec2>{{0.0, 0.0}, {0.1, -0.05}}, before, after, 0.006));
    EXPECT_FALSE(continues_a_side(std::vector<Vec2>{{0.0, 0.0}}, std::vector<Vec2>{{-1, 0}, {-2, 0}}, after, 0.006));
}

TEST(Kinks, ACornerKeepsItsPointsAndLosesItsBadOne) {
    std::vector<Vec2> chain;
    for (int i = -20; i <= 20; ++i)
        chain.emplace_back(0.3 * i, i < 0 ? 0.0 : 0.2 * i);
    EXPECT_EQ(find_bad_points(chain, false, 0.010).count, 0U);
    chain[20].y() -= 0.08;  // the corner itself
    const auto found = find_bad_points(chain, false, 0.010);
    EXPECT_TRUE(found.bad[20]);
}

}  // namespace
}  // namespace cmm::fitting
