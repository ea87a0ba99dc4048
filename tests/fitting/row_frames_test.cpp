// SPDX-License-Identifier: Apache-2.0
#include "fitting/row_frames.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/column_smoother.hpp"
#include "support/fitted_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t row_count = 25, column_count = 180;

/// An oval, which turns by a radian and moves as it goes up; places are `spread_mm` off along it, and the middle row is
/// shifted.
struct TurningPart {
    std::vector<double> z;
    RowColumns columns;

    explicit TurningPart(double spread_mm = 0.0, double shift_mm = 0.0) {
        core::Rng rng(3);
        columns.reset(column_count, row_count);
        for (std::size_t k = 0; k < row_count; ++k) {
            z.push_back(4.0 * double(k));
            for (std::size_t i = 0; i < column_count; ++i) {
                const double a = 2.0 * std::numbers::pi * double(i) / column_count + spread_mm * rng.normal() / 20.0;
                columns.set(i, k,
                            placed(Vec2(20 * std::cos(a), 8 * std::sin(a)), z[k]) +
                                Vec2(0.0, k == row_count / 2 ? shift_mm : 0.0));
            }
        }
    }
    static Vec2 placed(const Vec2& place, double z) {
        return Eigen::Rotation2Dd(0.008 * z + 2e-5 * z * z) * place + Vec2(0.05 * z, 3.0 - 4e-6 * z * z * z);
    }
    double largest_apart(const RowFrames& frames, std::size_t but_row = row_count) const {
        double largest = 0.0;
        for (std::size_t k = 1; k < row_count; ++k)
            for (std::size_t i = 0; i < column_count; ++i)
                if (k != but_row)
                    largest =
                        std::max(largest, (frames.into(k, columns.at(i, k)) - frames.into(0, columns.at(i, 0))).norm());
        return largest;
    }
};

TEST(RowFrames, HaveAPartThatTurnsAndMovesAtRest) {
    const TurningPart part;
    const RowFrames frames(part.z, part.columns);
    EXPECT_GT(part.largest_apart(RowFrames(row_count)), 10.0);
    EXPECT_LT(part.largest_apart(frames), 1e-9);
    for (std::size_t k = 0; k < row_count; ++k) {
        const Vec2 place = part.columns.at(7, k);
        EXPECT_LT((frames.out_of(k, frames.into(k, place)) - place).norm(), 1e-12);
    }
}

/// Places lie some 20 um off along their rows, a row from the other.
TEST(RowFrames, HardlyAnswerToWhereAlongTheirRowsPlacesLie) {
    const TurningPart part(0.02);
    const RowFrames frames(part.z, part.columns);
    const TurningPart at_rest;
    EXPECT_LT(at_rest.largest_apart(frames), 3e-3);
}

TEST(RowFrames, DoNotGoAlongWithOneRowThatLiesApart) {
    const TurningPart part(0.0, 0.05);
    const RowFrames frames(part.z, part.columns);
    EXPECT_LT(part.largest_apart(frames, row_count / 2), 1e-4);
    EXPECT_NEAR((frames.into(12, part.columns.at(7, 12)) - frames.into(0, part.columns.at(7, 0))).norm(), 0.05, 1e-4);
}

/// 55 degrees of twist over the height, 1 um of noise.
TEST(RowFrames, AFanNeedsHardlyMoreThanCubicsOverZ) {
    const FittedBlade fitted(families::Family::fan, 5);
    ASSERT_TRUE(fitted.surface.centres());
    const auto& freedom = fitted.surface.centres()->freedom_v;
    double sum = 0.0;
    for (const double f : freedom)
        sum += f;
    EXPECT_LT(sum / double(freedom.size()), 5.5);
}

}  // namespace
}  // namespace cmm::fitting
