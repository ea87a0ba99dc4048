// SPDX-License-Identifier: Apache-2.0
#include "fitting/roughness.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace cmm::fitting {
namespace {

constexpr std::size_t knots = 40, window = 3;
constexpr double to_binary_digits = 3e-4;  // variances are rounded to twelve

std::vector<std::size_t> same_knots() {
    std::vector<std::size_t> from(knots);
    std::iota(from.begin(), from.end(), std::size_t{0});
    return from;
}

/// A ramp at knots 18 to 20 from where the logarithm of the variance falls by 2 each knot: to the side's, -9, before
/// it, to the arc's, -8, behind; far behind it falls on.
std::vector<double> round_a_ramp() {
    std::vector<double> variance(knots);
    for (std::size_t k = 0; k < knots; ++k) {
        const double away = k < 18 ? 18.0 - double(k) : k > 20 ? double(k) - 20.0 : 0.0;
        const double log = k < 19 ? std::max(-2.0 * away, -9.0) : std::max(-2.0 * away, k < 30 ? -8.0 : -12.0);
        variance[k] = std::exp(log);
    }
    return variance;
}

TEST(Roughness, OfARampGoesWithItAndWithWhatItTellsItsNeighbours) {
    Roughness roughness;
    const auto variance = round_a_ramp();
    roughness.reset(variance, window, 1.0);
    roughness.carry_over(same_knots(), {{18, 20}});
    const auto& calm = roughness.variance();
    for (std::size_t k = 0; k < knots; ++k) {
        const double expected = k >= 13 && k <= 20 ? std::exp(-9.0) : k > 20 && k <= 24 ? std::exp(-8.0) : variance[k];
        EXPECT_NEAR(std::log(calm[k]), std::log(expected), to_binary_digits) << k;
    }
}

/// No farther than to those who share a scale with a knot that shares one with the ramp.
TEST(Roughness, StaysFarFromTheRamp) {
    std::vector<double> variance(knots);
    for (std::size_t k = 0; k < knots; ++k)
        variance[k] = std::exp(-std::abs(double(k) - 20.0));
    Roughness roughness;
    roughness.reset(variance, window, 1.0);
    roughness.carry_over(same_knots(), {{19, 21}});
    for (std::size_t k = 0; k < knots; ++k) {
        const bool near = k + 1 + 2 * window >= 20 && k <= 21 + 2 * window;
        EXPECT_NEAR(std::log(roughness.variance()[k]), near ? -7.0 : std::log(variance[k]), to_binary_digits) << k;
    }
}

TEST(Roughness, OfARampRoundTheEnd) {
    std::vector<double> variance(knots, std::exp(-9.0));
    for (const std::size_t k : {38U, 39U, 0U, 1U, 2U, 3U, 4U})
        variance[k] = std::exp(-2.0 * std::abs(double(k < 20 ? k + knots : k) - 41.0));
    Roughness roughness;
    roughness.reset(variance, window, 1.0);
    roughness.carry_over(same_knots(), {{0, 2}});
    for (std::size_t k = 0; k < knots; ++k)
        EXPECT_NEAR(std::log(roughness.variance()[k]), -9.0, to_binary_digits) << k;
}

}  // namespace
}  // namespace cmm::fitting
