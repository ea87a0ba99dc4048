// SPDX-License-Identifier: Apache-2.0
#include "fitting/circle.hpp"

#include <gtest/gtest.h>

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

TEST(Circle, ReportedUncertaintyCoversTheTruth) {
    int covered = 0;
    for (int k = 0; k < 1000; ++k) {
        const auto fit = fit_circle(arc(1.2, 150.0, 30, 0.001, 9000 + k), 0.001);
        ASSERT_TRUE(fit);
        covered += std::abs(fit->radius - 1.2) <= fit->radius_u95;
    }
    EXPECT_GE(covered, 930);
    EXPECT_LE(covered, 995);
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
