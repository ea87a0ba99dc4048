// SPDX-License-Identifier: Apache-2.0
#include "fitting/outliers.hpp"
#include "fitting/spline_residual.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

std::vector<Vec2> circle(std::size_t n, double radius, double sigma, std::uint64_t seed) {
    core::Rng rng(seed);
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double a = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
        points.push_back((radius + sigma * rng.normal()) * Vec2(std::cos(a), std::sin(a)));
    }
    return points;
}

TEST(SplineResidual, IsTheSignedDistanceToTheNeighboursSpline) {
    const Vec2 a(0, 0), b(1, 0), c(3, 0), d(4, 0);
    EXPECT_NEAR(spline_residual(a, b, c, d, {2, -0.3}).distance_mm, 0.3, 1e-12) << "positive on the right";
    EXPECT_NEAR(spline_residual(a, b, c, d, {2, 0.2}).distance_mm, -0.2, 1e-12);
    EXPECT_EQ(spline_residual(a, a, c, d, {2, 0.2}).distance_mm, 0.0) << "no direction, no verdict";
    const auto at = [](double angle) { return Vec2(std::cos(angle), std::sin(angle)); };
    EXPECT_NEAR(spline_residual(at(-0.2), at(-0.1), at(0.1), at(0.2), 1.05 * at(0.0)).distance_mm, 0.05, 1e-4);
}

TEST(SplineResidual, EightSideBySideAreTheSameToTheLastBit) {
    core::Rng rng(12);
    for (int trial = 0; trial < 300; ++trial) {
        const std::ptrdiff_t by = 1 + trial % 3;
        // From nearly smooth to wild, so that one, two or all steps of the search are taken.
        auto points = circle(200, 2.5, std::pow(10.0, -5.0 + 0.02 * trial), static_cast<std::uint64_t>(trial));
        const auto first = static_cast<std::ptrdiff_t>(8 + rng.below(150));
        const auto at = [&](std::ptrdiff_t k) { return points[static_cast<std::size_t>(k)]; };
        const EightResiduals found = spline_residuals(&points[static_cast<std::size_t>(first)], by);
        for (std::ptrdiff_t k = 0; k < 8; ++k) {
            const std::ptrdiff_t i = first + k;
            const auto alone = spline_residual(at(i - 2 * by), at(i - by), at(i + by), at(i + 2 * by), at(i));
            ASSERT_EQ(found[static_cast<std::size_t>(k)].distance_mm, alone.distance_mm) << trial << ' ' << k;
            ASSERT_EQ(found[static_cast<std::size_t>(k)].gain, alone.gain) << trial << ' ' << k;
        }
    }
}

TEST(BadPoints, SinglesAndRunsOfThreeAreFoundExactly) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        auto points = circle(150, 2.5, 0.001, seed);
        core::Rng rng(seed + 1000);
        std::vector<char> bad(points.size(), 0);
        for (const std::size_t start : {std::size_t{0}, std::size_t{40}, std::size_t{90}}) {  // the first run wraps
            const std::size_t run = 1 + rng.below(3);
            for (std::size_t k = 0; k < run; ++k) {
                const std::size_t i = (start + points.size() - 1 + k) % points.size();
                points[i] *= 1.0 + rng.uniform(0.04, 0.4) / 2.5;
                bad[i] = 1;
            }
        }
        const auto found = find_bad_points(points, true, 0.002);
        EXPECT_EQ(found.bad, bad) << "seed " << seed;
        EXPECT_NEAR(found.sigma_mm, 0.001, 0.0006);
    }
}

/// Each of them is predicted as long as the others are among its neighbours: before they were tried as runs, 4, 8 and
/// 21 % of such points stayed.
TEST(BadPoints, LowRunsDoNotBearEachOtherOut) {
    for (std::size_t run = 2; run <= 4; ++run) {
        std::size_t missed = 0, lost = 0;
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            auto points = circle(800, 9.0, 0.001, seed);
            std::vector<char> bad(points.size(), 0);
            for (std::size_t start = 20; start + run < points.size(); start += 100)
                for (std::size_t i = start; i < start + run; ++i) {
                    points[i] *= 1.0 - 0.020 / 9.0;
                    bad[i] = 1;
                }
            const auto found = find_bad_points(points, true, 0.002);
            for (std::size_t i = 0; i < bad.size(); ++i) {
                missed += bad[i] && !found.bad[i];
                lost += !bad[i] && found.bad[i];
            }
        }
        EXPECT_LE(missed, 6 * run) << "of " << 320 * run << ", runs of " << run;
        EXPECT_LE(lost, 8U) << "runs of " << run;
    }
}

/// Only when that one is out can they be told.
TEST(BadPoints, LowRunsBesideAFarHigherOneAreFound) {
    std::size_t missed = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed) {
        auto points = circle(800, 9.0, 0.001, seed);
        for (const auto& [i, height_mm] : {std::pair{100, 0.015}, {101, 0.015}, {105, 0.12}, {106, 0.2}})
            points[static_cast<std::size_t>(i)] *= 1.0 + height_mm / 9.0;
        const auto found = find_bad_points(points, true, 0.002).bad;
        for (const std::size_t i : {100U, 101U, 105U, 106U})
            missed += found[i] == 0;
    }
    EXPECT_LE(missed, 8U) << "of 400";
}

TEST(BadPoints, GoodPointsStay) {
    std::size_t rejected = 0;
    for (std::uint64_t seed = 0; seed < 100; ++seed)
        rejected += find_bad_points(circle(300, 1.2, 0.001, seed), true, 0.002).count;
    EXPECT_EQ(rejected, 0U) << "of 30000";
}

TEST(BadPoints, TextureRaisesTheThreshold) {
    std::size_t rejected = 0;
    for (std::uint64_t seed = 0; seed < 50; ++seed)
        rejected += find_bad_points(circle(400, 8.0, 0.010, seed), true, 0.002).count;
    EXPECT_LE(rejected, 40U) << "of 20000, rms 10 um";
}

TEST(BadPoints, DenseScansAreJudgedInInterleavedChains) {
    auto points = circle(8000, 3.0, 0.001, 5);  // 2.4 um apart
    std::vector<char> bad(points.size(), 0);
    for (std::size_t i = 700; i < 703; ++i) {
        points[i] *= 1.0 + 0.12 / 3.0;
        bad[i] = 1;
    }
    EXPECT_EQ(find_bad_points(points, true, 0.002).bad, bad);
}

TEST(BadPoints, OpenChainsAreJudgedToo) {
    std::vector<Vec2> line;
    for (int i = 0; i < 30; ++i)
        line.emplace_back(0.2 * i, 0.0);
    line[0].y() = 0.2;  // no neighbours on one side: found through the points that it disturbs
    line[15].y() = 0.2;
    const auto found = find_bad_points(line, false, 0.002);
    EXPECT_EQ(found.count, 2U);
    EXPECT_TRUE(found.bad[0] && found.bad[15]);
}

TEST(BadPoints, ACornerKeepsItsPointsAndLosesItsBadOne) {
    std::vector<Vec2> chain;
    for (int i = -20; i <= 20; ++i)
        chain.emplace_back(0.3 * i, i < 0 ? 0.0 : 0.2 * i);
    EXPECT_EQ(find_bad_points(chain, false, 0.002).count, 0U);
    chain[20].y() -= 0.08;  // the corner itself
    const auto found = find_bad_points(chain, false, 0.002);
    EXPECT_TRUE(found.bad[20]);
    EXPECT_EQ(found.count, 1U);
}

TEST(BadPoints, GarbageEndsInTime) {
    core::Rng rng(1);
    std::vector<Vec2> points;
    for (int i = 0; i < 5000; ++i)
        points.emplace_back(rng.uniform(-10, 10), rng.uniform(-10, 10));
    const auto found = find_bad_points(points, true, 0.002);
    EXPECT_EQ(found.bad.size(), points.size());
    EXPECT_EQ(find_bad_points(std::vector<Vec2>(50, Vec2(1, 1)), true, 0.002).count, 0U);
    EXPECT_EQ(find_bad_points({}, true, 0.002).count, 0U);
}

/// 1 um of noise; points 19 to 21 lie 25 um low, and 36 lies apart. The cubics over the three had put out the good ones
/// beside them.
TEST(Outliers, ARunDoesNotChangePlacesWithItsNeighbours) {
    const std::vector<Vec2> points{
        {-14.8890, -0.5235},  {-15.1967, -0.7777},  {-15.5049, -1.0312},  {-15.8090, -1.2898},  {-16.1143, -1.5469},
        {-16.4155, -1.8086},  {-16.7157, -2.0716},  {-17.0146, -2.3361},  {-17.3101, -2.6043},  {-17.6051, -2.8733},
        {-17.8979, -3.1445},  {-18.1890, -3.4174},  {-18.4766, -3.6942},  {-18.7651, -3.9700},  {-19.0491, -4.2504},
        {-19.3332, -4.5308},  {-19.6130, -4.8153},  {-19.8917, -5.1010},  {-20.1703, -5.3869},  {-20.4258, -5.6945},
        {-20.6962, -5.9878},  {-20.9688, -6.2790},  {-21.2549, -6.5581},  {-21.5199, -6.8567},  {-21.7842, -7.1557},
        {-22.0469, -7.4563},  {-22.3057, -7.7601},  {-22.5614, -8.0666},  {-22.8171, -8.3731},  {-23.0692, -8.6824},
        {-23.3192, -8.9936},  {-23.5640, -9.3087},  {-23.8101, -9.6230},  {-24.0505, -9.9416},  {-24.2911, -10.2600},
        {-24.5276, -10.5816}, {-24.9097, -10.7941}, {-24.9527, -11.1696}, {-25.0996, -11.3809}, {-25.2135, -11.5461},
        {-25.3006, -11.6723},
    };
    const auto found = find_bad_points(points, false, 0.002);
    for (std::size_t i = 0; i < points.size(); ++i)
        EXPECT_EQ(found.bad[i] != 0, (i >= 19 && i <= 21) || i == 36) << i;
    EXPECT_EQ(found.count, 4U);
    for (const std::size_t i : {19U, 20U, 21U}) {
        EXPECT_NEAR(std::abs(found.residual[i]), 0.025, 0.004);
        EXPECT_LT(found.threshold_mm[i], 0.02);
    }
}

}  // namespace
}  // namespace cmm::fitting
