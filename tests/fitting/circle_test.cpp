// SPDX-License-Identifier: Apache-2.0
#include "fitting/circle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

std::vector<Vec2> arc(double radius, double degrees, std::size_t n, double sigma, std::uint64_t seed,
                      const Vec2& centre = {50, -80}) {
    core::Rng rng(seed);
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < n; ++i) {
        const double a =
            degrees * std::numbers::pi / 180.0 * (static_cast<double>(i) / static_cast<double>(n - 1) - 0.3);
        points.push_back(centre + (radius + sigma * rng.normal()) * Vec2(std::cos(a), std::sin(a)));
    }
    return points;
}

TEST(Circle, BothFitsAreExactWithoutNoise) {
    const auto points = arc(0.15, 120.0, 15, 0.0, 1);
    const auto kasa = fit_circle_kasa(points), best = fit_circle(points);
    ASSERT_TRUE(kasa && best);
    EXPECT_NEAR(kasa->radius, 0.15, 1e-11);
    EXPECT_NEAR(best->radius, 0.15, 1e-11);
    EXPECT_LT((best->centre - Vec2(50, -80)).norm(), 1e-10);
    EXPECT_NEAR(best->arc_angle, 120.0 * std::numbers::pi / 180.0, 1e-9);
    EXPECT_LT(best->rms, 1e-12);
}

/// A14: r = 0.15 mm, 15 points, sigma = 3 um, 90 degrees: Kasa is 3.5 um small, the geometric fit stays within 1.5 um.
TEST(Circle, GeometricFitRemovesTheBiasOfKasa) {
    double kasa = 0.0, best = 0.0;
    const int runs = 4000;
    for (int k = 0; k < runs; ++k) {
        const auto points = arc(0.15, 90.0, 15, 0.003, 100 + k);
        kasa += fit_circle_kasa(points)->radius / runs;
        best += fit_circle(points)->radius / runs;
    }
    EXPECT_NEAR(kasa, 0.15 - 0.0035, 0.0008);
    EXPECT_NEAR(best, 0.15, 0.0015);
}

struct Trials {
    double bias_mm = 0.0;
    double covered = 0.0;  // share of the intervals that hold the true radius
};

/// 2 000 arcs with radial noise. `freedom` of an earlier estimate of the noise: 0 none, otherwise drawn anew each time.
Trials trials(double radius, double degrees, std::size_t n, double sigma, int freedom, std::uint64_t seed) {
    Trials result;
    core::Rng rng(seed);
    constexpr int runs = 2000;
    for (int k = 0; k < runs; ++k) {
        Noise known{0.0, static_cast<double>(freedom)};
        for (int i = 0; i < freedom; ++i)
            known.sigma_mm += std::pow(sigma * rng.normal(), 2) / freedom;
        known.sigma_mm = std::sqrt(known.sigma_mm);
        const auto fit = fit_circle(arc(radius, degrees, n, sigma, seed + 1 + k), known);
        if (!fit) continue;
        result.bias_mm += (fit->radius - radius) / runs;
        result.covered += (std::abs(fit->radius - radius) <= fit->radius_u95) / static_cast<double>(runs);
    }
    return result;
}

TEST(Circle, BiasBelowAMicrometreAndIntervalsThatCoverNinetyFivePercent) {
    std::uint64_t seed = 1000000;
    for (const double degrees : {90.0, 130.0, 180.0})
        for (const double radius : {0.15, 0.5, 2.0})
            for (const std::size_t n : {10U, 25U, 72U, 200U})
                for (const int freedom : {0, 40, 1000}) {
                    const Trials result = trials(radius, degrees, n, 0.003, freedom, seed += 10000);
                    EXPECT_LT(std::abs(result.bias_mm), 0.001) << degrees << ' ' << radius << ' ' << n;
                    EXPECT_GE(result.covered, 0.93) << degrees << ' ' << radius << ' ' << n << ' ' << freedom;
                    EXPECT_LE(result.covered, 0.97) << degrees << ' ' << radius << ' ' << n << ' ' << freedom;
                }
}

/// Points that scatter more than the machine does: the residuals speak, not what was known.
TEST(Circle, FormErrorWidensTheInterval) {
    const auto points = arc(0.5, 150.0, 40, 0.004, 77);
    const auto alone = fit_circle(points), told = fit_circle(points, {0.001, 1000.0});
    ASSERT_TRUE(alone && told);
    EXPECT_DOUBLE_EQ(told->radius_u95, alone->radius_u95);
    EXPECT_DOUBLE_EQ(told->noise.freedom, 37.0);
    EXPECT_NEAR(told->radius_u95, coverage_95(37.0) * std::sqrt(told->covariance(2, 2)), 1e-15);
}

TEST(Circle, TheCovarianceIsThatOfManyFits) {
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    constexpr int runs = 4000;
    const Vec2 centre(50, -80);
    for (int k = 0; k < runs; ++k) {
        const auto fit = fit_circle(arc(0.8, 140.0, 40, 0.001, 500000 + k, centre));
        ASSERT_TRUE(fit);
        const Eigen::Vector3d off(fit->centre.x() - centre.x(), fit->centre.y() - centre.y(), fit->radius - 0.8);
        scatter += off * off.transpose() / runs;
    }
    const auto exact = fit_circle(arc(0.8, 140.0, 40, 0.0, 1), {0.001, std::numeric_limits<double>::infinity()});
    EXPECT_LT((exact->covariance - scatter).norm(), 0.08 * scatter.norm());
}

TEST(Circle, TheArcAngleIsThatOfAnyOrderAndDirection) {
    core::Rng rng(5);
    for (const double degrees : {65.0, 90.0, 179.0, 181.0, 270.0, 350.0}) {
        for (int turn = 0; turn < 16; ++turn) {
            std::vector<Vec2> points;
            for (int i = 0; i < 60; ++i) {
                const double a = (turn * 22.5 + degrees * (i * 37 % 60) / 59.0) * std::numbers::pi / 180.0;
                points.push_back(Vec2(3, 4) + 0.7 * Vec2(std::cos(a), std::sin(a)));
            }
            const auto fit = fit_circle(points);
            ASSERT_TRUE(fit);
            EXPECT_NEAR(fit->arc_angle, degrees * std::numbers::pi / 180.0, 1e-8) << turn;
        }
    }
}

TEST(Circle, RefusesWhatDeterminesNoRadius) {
    EXPECT_FALSE(fit_circle(arc(0.5, 40.0, 20, 0.0, 1)));
    EXPECT_FALSE(fit_circle(arc(0.5, 180.0, 4, 0.0, 1)));
    EXPECT_FALSE(fit_circle(std::vector<Vec2>(10, Vec2(1, 2))));
    std::vector<Vec2> line;
    for (int i = 0; i < 10; ++i)
        line.emplace_back(i, 2.0 * i);
    EXPECT_FALSE(fit_circle(line));
    const auto refused = fit_circle(arc(0.5, 40.0, 20, 0.0, 1));
    EXPECT_NE(refused.error().message.find("40 degrees"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace cmm::fitting
