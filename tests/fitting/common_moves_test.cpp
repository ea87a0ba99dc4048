// SPDX-License-Identifier: Apache-2.0
#include "fitting/common_moves.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <iostream>
#include <numbers>
#include <vector>

#include "core/rng.hpp"
#include "fitting/known_fit.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t row_count = 12, point_count = 240;

/// What the points of all rows leave on the average, rms: ellipses that are taken to be smoother than they are.
double left_by_all_um(int times) {
    std::vector<KnownFit> fits;
    for (std::size_t k = 0; k < row_count; ++k) {
        core::Rng rng(k + 1);
        std::vector<Vec2> points;
        for (std::size_t i = 0; i < point_count; ++i) {
            const double t = 2.0 * std::numbers::pi * static_cast<double>(i) / point_count;
            const Vec2 normal = Vec2(std::cos(t) / 8.0, std::sin(t) / 2.0).normalized();
            points.push_back(Vec2(8.0 * std::cos(t), 2.0 * std::sin(t)) + 1e-3 * rng.normal() * normal);
        }
        const SmoothCurve smooth = smooth_closed(points).value();
        KnownShape shape;
        constexpr std::size_t spans = 60;
        for (std::size_t i = 0; i <= spans; ++i)
            shape.breaks.push_back(smooth.curve.period() * static_cast<double>(i) / spans);
        shape.roughness.assign(spans, 1e-4);
        fits.emplace_back(smooth, 0.0);
        EXPECT_TRUE(fits.back().fit(shape));
    }
    std::vector<KnownFit*> all;
    for (KnownFit& fit : fits)
        all.push_back(&fit);
    move_together(all, times, 6);
    std::vector<double> mean(point_count, 0.0);
    for (KnownFit& fit : fits) {
        const SmoothCurve curve = std::move(fit).finish();
        for (std::size_t i = 0; i < point_count; ++i)
            mean[i] += 1e3 * curve.residual[i] / row_count;
    }
    double squares = 0.0;
    for (const double left : mean)
        squares += left * left / point_count;
    return std::sqrt(squares);
}

TEST(CommonMoves, TakeAwayWhatThePointsOfAllRowsLeave) {
    const double noise_of_mean_um = 1.0 / std::sqrt(static_cast<double>(row_count));
    const double apart = left_by_all_um(0), once = left_by_all_um(1), thrice = left_by_all_um(3);
    std::cout << "left by all: " << apart << " um by single rows, " << once << " moved once, " << thrice
              << " three times\n";
    EXPECT_GT(apart, 2.0 * noise_of_mean_um);
    EXPECT_LT(once, apart);
    EXPECT_LT(thrice, once);
    EXPECT_LT(thrice, noise_of_mean_um + 0.5 * (apart - noise_of_mean_um));
}

}  // namespace
}  // namespace cmm::fitting
