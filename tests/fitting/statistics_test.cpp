// SPDX-License-Identifier: Apache-2.0
#include "fitting/statistics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Against a full sort: short and long, all alike, sorted, with one large value, and so that the sample misleads.
TEST(Statistics, TheNthSmallestIsThatOfTheSortedValues) {
    core::Rng rng(3);
    for (const std::size_t n : {1U, 2U, 255U, 256U, 257U, 2000U, 20000U}) {
        for (int kind = 0; kind < 5; ++kind) {
            std::vector<double> values(n);
            for (std::size_t i = 0; i < n; ++i) {
                const auto place = static_cast<double>(i);
                values[i] = kind == 0   ? std::abs(rng.normal())
                            : kind == 1 ? 2.0
                            : kind == 2 ? -place
                            : kind == 3 ? (i == n / 2 ? 1e9 : std::floor(4.0 * rng.uniform()))
                                        : (i % std::max<std::size_t>(1, n / 64) == 0 ? 1e3 + place : place);
            }
            std::vector<double> sorted = values;
            std::sort(sorted.begin(), sorted.end());
            for (const double share : {0.0, 0.1, 0.4, 0.5, 0.9, 1.0}) {
                const auto nth = static_cast<std::size_t>(share * static_cast<double>(n - 1));
                std::vector<double> work = values;
                EXPECT_EQ(nth_smallest(work, nth), sorted[nth]) << n << " " << kind << " " << share;
            }
        }
    }
}

/// Python: NormalDist().inv_cdf(1 - risk), and of (1 - risk)^(1/count).
TEST(Statistics, UpperDeviatesAreThoseOfTheNormalDistribution) {
    EXPECT_NEAR(upper_deviate(0.05), 1.6448536, 1e-7);
    EXPECT_NEAR(upper_deviate(0.05 / 3.0), 2.1280452, 1e-7);
    EXPECT_NEAR(upper_deviate(0.001), 3.0902323, 1e-7);
    EXPECT_NEAR(upper_deviate_of_largest(0.05, 1.0), 1.6448536, 1e-7);
    EXPECT_NEAR(upper_deviate_of_largest(0.05, 200.0), 3.4739445, 1e-6);
}

/// GUM (JCGM 100:2008), table G.2, 95 %.
TEST(Statistics, StudentsTIsThatOfTheTable) {
    for (const auto& [freedom, t] : {std::pair{1.0, 12.71},
                                     {2.0, 4.30},
                                     {3.0, 3.18},
                                     {4.0, 2.78},
                                     {5.0, 2.57},
                                     {6.0, 2.45},
                                     {7.0, 2.36},
                                     {8.0, 2.31},
                                     {9.0, 2.26},
                                     {10.0, 2.23},
                                     {15.0, 2.13},
                                     {20.0, 2.09},
                                     {30.0, 2.04},
                                     {50.0, 2.01},
                                     {100.0, 1.984},
                                     {infinity, 1.960}})
        EXPECT_NEAR(coverage_95(freedom), t, 0.0051) << freedom;
    EXPECT_TRUE(std::isinf(coverage_95(0.0)));
}

/// Upper 0.1 % points of chi-square: Abramowitz and Stegun, table 26.8.
TEST(Statistics, ChiSquareLimitIsThatOfTheTable) {
    for (const auto& [freedom, limit] : {std::pair{10.0, 29.588}, {20.0, 45.315}, {30.0, 59.703}, {100.0, 149.449}})
        EXPECT_NEAR(chi_square_limit(freedom, 3.0902), limit, 0.01 * limit) << freedom;
}

TEST(Statistics, NoiseIsPooledUnlessTheResidualsAreTooLarge) {
    const Noise pooled = combined_noise(40.0 * 1.21, 40.0, {1.0, 60.0});
    EXPECT_NEAR(pooled.sigma_mm, std::sqrt((60.0 + 48.4) / 100.0), 1e-14);
    EXPECT_EQ(pooled.freedom, 100.0);
    EXPECT_EQ(combined_noise(40.0 * 9.0, 40.0, {1.0, 60.0}).sigma_mm, 3.0);
    EXPECT_EQ(combined_noise(40.0 * 1.2, 40.0, {1.0, infinity}).sigma_mm, 1.0);
    EXPECT_EQ(combined_noise(40.0 * 4.0, 40.0, {}).sigma_mm, 2.0);
    // The 0.1 % point of F(40, 60) is 2.41 (published tables).
    EXPECT_EQ(combined_noise(40.0 * 2.37, 40.0, {1.0, 60.0}).freedom, 100.0);
    EXPECT_EQ(combined_noise(40.0 * 2.46, 40.0, {1.0, 60.0}).freedom, 40.0);
}

TEST(Statistics, TheLargestOfManyIsCoveredByMore) {
    EXPECT_NEAR(coverage_95_of_largest(1), 1.959964, 1e-6);
    EXPECT_NEAR(coverage_95_of_largest(2), 2.236477, 1e-6);  // Sidak's t table, infinite degrees of freedom
    EXPECT_NEAR(coverage_95_of_largest(10), 2.799625, 1e-6);
    core::Rng rng(3);
    int inside = 0;
    for (int trial = 0; trial < 4000; ++trial) {
        double largest = 0.0;
        for (int i = 0; i < 32; ++i)
            largest = std::max(largest, std::abs(rng.normal()));
        inside += largest < coverage_95_of_largest(32) ? 1 : 0;
    }
    EXPECT_NEAR(inside / 4000.0, 0.95, 0.012);
}

}  // namespace
}  // namespace cmm::fitting
