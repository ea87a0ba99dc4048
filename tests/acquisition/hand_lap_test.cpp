// SPDX-License-Identifier: Apache-2.0
#include "acquisition/hand_lap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/rng.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;

/// Ball centres round a thin slab with round ends: 50 mm long, 3 mm thick, counter-clockwise from the middle of the
/// upper side, a step apart.
std::vector<Vector2d> slab(double step_mm) {
    constexpr double half = 25.0;
    constexpr double radius = 1.5;
    constexpr double end = std::numbers::pi * radius;
    constexpr double length = 4.0 * half + 2.0 * end;
    std::vector<Vector2d> points;
    for (double s = 0.0; s < length; s += step_mm) {
        double at = s;
        if (at < half) {
            points.emplace_back(-at, radius);
        } else if ((at -= half) < end) {
            points.emplace_back(-half - radius * std::sin(at / radius), radius * std::cos(at / radius));
        } else if ((at -= end) < 2.0 * half) {
            points.emplace_back(-half + at, -radius);
        } else if ((at -= 2.0 * half) < end) {
            points.emplace_back(half + radius * std::sin(at / radius), -radius * std::cos(at / radius));
        } else {
            points.emplace_back(half - (at - end), radius);
        }
    }
    return points;
}

/// The number of points after which the lap is closed; 0: it is not.
std::size_t closed_after(const std::vector<Vector2d>& points) {
    HandLap lap;
    for (std::size_t k = 0; k < points.size(); ++k) {
        lap.add(points[k]);
        if (lap.closed()) return k + 1;
    }
    return 0;
}

std::vector<Vector2d> twice(std::vector<Vector2d> points) {
    const auto once = points;
    points.insert(points.end(), once.begin(), once.end());
    return points;
}

TEST(HandLap, ClosesWithTheFirstPointPastTheStartWhateverTheStepAndTheWayRound) {
    for (const double step_mm : {0.05, 0.3, 1.0, 2.0, 3.0}) {
        auto points = slab(step_mm);
        const std::size_t lap = points.size();
        EXPECT_EQ(closed_after(points), 0U) << step_mm;
        const auto ahead = closed_after(twice(points));
        EXPECT_GE(ahead, lap) << step_mm;
        EXPECT_LE(ahead, lap + 2) << step_mm;
        std::reverse(points.begin(), points.end());
        const auto back = closed_after(twice(points));
        EXPECT_GE(back, lap) << step_mm;
        EXPECT_LE(back, lap + 2) << step_mm;
    }
}

TEST(HandLap, ATremblingHandClosesNothing) {
    core::Rng rng(5);
    const auto points = slab(0.2);
    std::vector<Vector2d> shaken;
    for (const auto& point : twice(points)) {
        // Stays for a while, and now and then a point is far off.
        for (int k = 0; k < 4; ++k)
            shaken.emplace_back(point + 0.02 * Vector2d(rng.normal(), rng.normal()));
        if (rng.below(40) == 0) shaken.emplace_back(point + Vector2d(0.0, 0.8));
    }
    const auto closed = closed_after(shaken);
    EXPECT_GE(closed, points.size() * 4 - 8);
    EXPECT_LE(closed, points.size() * 9 / 2);
}

TEST(HandLap, ThereAndBackIsNoLap) {
    const auto points = slab(0.5);
    std::vector<Vector2d> way(points.begin(), points.begin() + 120);
    way.insert(way.end(), way.rbegin(), way.rend());
    EXPECT_EQ(closed_after(way), 0U);
    EXPECT_EQ(closed_after({}), 0U);
    EXPECT_EQ(closed_after({Vector2d(1, 1), Vector2d(1, 1), Vector2d(1, 1)}), 0U);
}

}  // namespace
}  // namespace cmm::acquisition
