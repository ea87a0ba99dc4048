// SPDX-License-Identifier: Apache-2.0
/// What rows know together, against exact truth.
#include "fitting/settled_rows.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

#include "support/measured_rows.hpp"

namespace cmm::fitting {
namespace {

constexpr int rounds = 8;

/// Where an arc meets a side; single rows know the place to some hundredths of a millimetre, or not at all.
TEST(SettledRows, HaveTheirJointsInCommon) {
    const families::TwistedBlade blade(families::Family::turbine, 3);
    const MeasuredRows data = measured_rows(blade, 24);
    const auto settled = settle_rows(data.rows, rounds);
    ASSERT_EQ(settled.size(), data.rows.size());
    double own_squares = 0.0, squares = 0.0, largest = 0.0;
    std::size_t own_count = 0;
    for (std::size_t k = 0; k < settled.size(); ++k) {
        const auto off = [&](const SurfaceRow& row, double t) {
            const Vec2 p = row.smooth().curve.jet(t).position;
            double nearest = std::numeric_limits<double>::infinity();
            for (const double joint : {1.0, 2.0, 3.0, 4.0})
                nearest = std::min(nearest, (p - blade.at(joint, row.z_mm()).position.head<2>()).norm());
            return nearest;
        };
        for (const auto& joint : data.rows[k].features().joints)
            if (joint) {
                own_squares += std::pow(off(data.rows[k], data.rows[k].parameter(joint->s_mm)), 2);
                ++own_count;
            }
        ASSERT_EQ(settled[k].smooth().joints.size(), 4U) << "row " << k;
        for (const CurvatureStep& joint : settled[k].smooth().joints) {
            squares += std::pow(off(settled[k], joint.t), 2);
            largest = std::max(largest, off(settled[k], joint.t));
        }
        EXPECT_EQ(settled[k].smooth().parameter.size(), data.rows[k].smooth().parameter.size());
        EXPECT_NEAR(settled[k].smooth().sigma_mm, 1e-3, 0.2e-3);
    }
    const double own_rms = std::sqrt(own_squares / double(own_count)), rms = std::sqrt(squares / (4.0 * 24.0));
    std::cout << "joints off: " << own_rms << " mm by single rows (" << own_count << " of 96), " << rms
              << " mm together, at most " << largest << "\n";
    EXPECT_LT(own_count, 96U) << "nothing to find out";
    EXPECT_LT(rms, 0.3 * own_rms);
    EXPECT_LT(rms, 2e-3);

    // A single row has nobody to ask.
    const auto alone = settle_rows(std::span(data.rows).first(1), rounds);
    ASSERT_EQ(alone.size(), 1U);
    EXPECT_EQ(alone[0].smooth().joints.size(), data.rows[0].smooth().joints.size());
    EXPECT_TRUE(settle_rows({}, rounds).empty());
}

/// How far a row's curve is off the part, over all of it and beside a point, in mm.
struct RowErrors {
    double largest = 0.0, at_place = 0.0;
};
RowErrors errors_of(const SurfaceRow& row, const families::TwistedBlade& blade, const Vec2& place) {
    const auto truth = blade.section(row.z_mm());
    const auto& curve = row.smooth().curve;
    RowErrors errors;
    double nearest = std::numeric_limits<double>::infinity();
    constexpr int places = 800;
    for (int i = 0; i < places; ++i) {
        const Vec2 p = curve.jet(curve.period() * i / places).position;
        const double off = std::abs(truth.closest(p).distance);
        errors.largest = std::max(errors.largest, off);
        if ((p - place).norm() < nearest) {
            nearest = (p - place).norm();
            errors.at_place = off;
        }
    }
    return errors;
}

TEST(SettledRows, AreNearerTheTruthThanSingleOnes) {
    for (const auto family : families::all_families) {
        const families::TwistedBlade blade(family, 4);
        const MeasuredRows data = measured_rows(blade, 24);
        const auto settled = settle_rows(data.rows, rounds);
        double alone = 0.0, together = 0.0;  // the largest of each row, squared
        for (std::size_t k = 0; k < settled.size(); ++k) {
            alone += std::pow(errors_of(data.rows[k], blade, Vec2::Zero()).largest, 2) / 24.0;
            together += std::pow(errors_of(settled[k], blade, Vec2::Zero()).largest, 2) / 24.0;
        }
        std::cout << blade.name() << ": largest error of a row, rms " << 1e3 * std::sqrt(alone)
                  << " um by single rows, " << 1e3 * std::sqrt(together) << " together\n";
        EXPECT_LT(together, alone) << blade.name();
    }
}

/// Three points of one row are off by eight times the noise: not the part, as the rows beside know.
TEST(SettledRows, AFewBadPointsDoNotBendTheirRow) {
    const families::TwistedBlade blade(families::Family::compressor, 3);
    constexpr std::size_t row = 9, bad = 250;
    Vec2 place;
    const MeasuredRows data = measured_rows(blade, 24, [&](std::size_t k, std::vector<Vec2>& points) {
        if (k != row) return;
        place = points[bad];
        const Vec2 along = (points[bad + 3] - points[bad - 3]).normalized();
        for (std::size_t i = bad - 1; i <= bad + 1; ++i)
            points[i] += 8e-3 * Vec2(along.y(), -along.x());
    });
    const auto settled = settle_rows(data.rows, rounds);
    const auto alone = errors_of(data.rows[row], blade, place), together = errors_of(settled[row], blade, place);
    EXPECT_GT(alone.at_place, 3e-3) << "nothing to mend";
    EXPECT_LT(together.at_place, 1.5e-3);
    EXPECT_EQ(settled[row].smooth().parameter.size(), data.rows[row].smooth().parameter.size()) << "no point is lost";
}

/// Where a row has no points its own curve says nothing against what all others tell.
TEST(SettledRows, WhereARowLacksPointsTheOthersTellIt) {
    for (const auto& [family, seed] : {std::pair{families::Family::turbine, 3}, {families::Family::fan, 7}}) {
        const families::TwistedBlade blade(family, static_cast<std::uint64_t>(seed));
        constexpr std::size_t row = 9, count = 24;
        const auto truth = blade.section(2 + (blade.height() - 4) * double(row) / double(count - 1));
        const MeasuredRows data = measured_rows(blade, count, [&](std::size_t k, std::vector<Vec2>& points) {
            if (k != row) return;
            std::erase_if(points, [&](const Vec2& p) {
                const double t = truth.closest(p).t;
                return t > 3.002 && t < 3.025;
            });
        });
        const auto settled = settle_rows(data.rows, rounds);
        EXPECT_GT(errors_of(data.rows[row], blade, Vec2::Zero()).largest, 10e-3) << "nothing to mend";
        EXPECT_LT(errors_of(settled[row], blade, Vec2::Zero()).largest, 2.5e-3) << blade.name();
    }
}

/// A single point far off is there because somebody wants it: its row follows it as it did.
TEST(SettledRows, APointThatSomebodyKeptIsFollowed) {
    const families::TwistedBlade blade(families::Family::compressor, 3);
    constexpr std::size_t row = 9, kept = 250;
    Vec2 place;
    const MeasuredRows data = measured_rows(blade, 24, [&](std::size_t k, std::vector<Vec2>& points) {
        if (k != row) return;
        place = points[kept];
        const Vec2 along = (points[kept + 1] - points[kept - 1]).normalized();
        points[kept] += 60e-3 * Vec2(along.y(), -along.x());
    });
    const double alone = errors_of(data.rows[row], blade, place).at_place;
    const double together = errors_of(settle_rows(data.rows, rounds)[row], blade, place).at_place;
    EXPECT_GT(alone, 10e-3) << "not followed before";
    EXPECT_GT(together, 0.8 * alone);
}

/// A dent of 20 um and 30 points that only one row has is the part's.
TEST(SettledRows, ADentOfOneRowStays) {
    const families::TwistedBlade blade(families::Family::turbine, 5);
    constexpr std::size_t row = 9, first = 90, points_of_dent = 30;
    Vec2 place;
    const MeasuredRows data = measured_rows(blade, 24, [&](std::size_t k, std::vector<Vec2>& points) {
        if (k != row) return;
        const auto whole = points;
        place = whole[first + points_of_dent / 2];
        for (std::size_t i = 0; i <= points_of_dent; ++i) {
            const Vec2 along = (whole[first + i + 1] - whole[first + i - 1]).normalized();
            const double depth = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * double(i) / points_of_dent);
            points[first + i] -= 20e-3 * depth * Vec2(along.y(), -along.x());
        }
    });
    const auto settled = settle_rows(data.rows, rounds);
    EXPECT_NEAR(errors_of(data.rows[row], blade, place).at_place, 20e-3, 1.5e-3);
    EXPECT_NEAR(errors_of(settled[row], blade, place).at_place, 20e-3, 1.5e-3);
    for (const std::size_t beside : {row - 1, row + 1})
        EXPECT_LT(errors_of(settled[beside], blade, place).largest, 3e-3);
    EXPECT_EQ(settled[row].smooth().joints.size(), settled[row + 1].smooth().joints.size());
}

}  // namespace
}  // namespace cmm::fitting
