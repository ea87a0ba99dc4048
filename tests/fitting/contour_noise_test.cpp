// SPDX-License-Identifier: Apache-2.0
/// What is not known of the lean, in numbers of many points: added as a bound, or drawn.
#include "fitting/contour_noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "fitting/section.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t doubted_points = 240;
constexpr double doubt_mm = 1e-3;

/// U95 of a mean over so many points from the first on, when nothing but the doubt is known of the contour.
template <class Sign>
double u95_of_mean(std::size_t points, Sign&& drawn_sign) {
    std::vector<ContourPoint> contour(doubted_points);
    Sensitivity mean;
    for (std::size_t i = 0; i < doubted_points; ++i) {
        contour[i].arc_length_mm = 0.5 * static_cast<double>(i);
        contour[i].bound_mm = doubt_mm;
        contour[i].drawn_mm = drawn_sign(i) * doubt_mm;
        if (i < points) mean.add(i, 1.0 / static_cast<double>(points));
    }
    return ContourNoise().of(contour, mean).u95;
}

TEST(ContourNoise, ABoundIsAddedFromEveryPoint) {
    const auto bound = [](std::size_t) { return 0.0; };
    EXPECT_NEAR(u95_of_mean(doubted_points, bound), doubt_mm, 1e-15);
    EXPECT_NEAR(u95_of_mean(1, bound), doubt_mm, 1e-15);
}

TEST(ContourNoise, WhatTheOthersMissedAlikeAddsUp) {
    const auto alike = [](std::size_t) { return 1.0; };
    EXPECT_GT(u95_of_mean(doubted_points, alike), doubt_mm);
    EXPECT_LT(u95_of_mean(doubted_points, alike), 1.1 * doubt_mm);
    EXPECT_NEAR(u95_of_mean(1, alike), std::sqrt(2.0) * doubt_mm, 1e-15);
}

TEST(ContourNoise, WhatTheyMissedByChanceDoesNot) {
    const auto turning = [](std::size_t i) { return i % 2 == 0 ? 1.0 : -1.0; };
    EXPECT_LT(u95_of_mean(doubted_points, turning), 0.01 * doubt_mm);
    // Over two sides that were missed to either hand the mean is right, and half of the doubt is not.
    const auto halves = [](std::size_t i) { return i < doubted_points / 2 ? 1.0 : -1.0; };
    const double both = u95_of_mean(doubted_points, halves);
    EXPECT_GT(both, 0.2 * doubt_mm);
    EXPECT_LT(both, 0.5 * doubt_mm);
}

}  // namespace
}  // namespace cmm::fitting
