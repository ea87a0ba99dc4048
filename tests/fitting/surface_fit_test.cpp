// SPDX-License-Identifier: Apache-2.0
/// Surfaces through rows of unequal length against exact truth.
#include "fitting/surface_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/point_deviation.hpp"
#include "fitting/row_alignment.hpp"
#include "support/measured_rows.hpp"

namespace cmm::fitting {
namespace {

TEST(SurfaceFit, RowsOfUnequalLength) {
    const families::TwistedBlade blade(families::Family::compressor, 6);
    const MeasuredRows data = measured_rows(blade, 60);
    const auto fit = fit_surface(data.rows);
    ASSERT_TRUE(fit) << fit.error().message;
    core::Rng rng(3);
    double squares = 0.0, largest = 0.0;
    constexpr int judged = 4000;
    for (int level = 0; level < 20; ++level) {
        const double z = rng.uniform(2, blade.height() - 2);
        const auto truth = blade.section(z);
        for (int i = 0; i < judged / 20; ++i) {
            const Vec3 p = fit->surface.position({rng.uniform(0, fit->surface.u().back()), z});
            EXPECT_NEAR(p.z(), z, 1e-9);
            const double off = truth.closest(p.head<2>()).distance;
            squares += off * off;
            largest = std::max(largest, std::abs(off));
        }
    }
    std::cout << "surface through 60 rows: rms " << 1e3 * std::sqrt(squares / judged) << " um, max " << 1e3 * largest
              << " um, rows off by " << 1e3 * fit->row_sigma_mm << " um\n";
    EXPECT_LT(std::sqrt(squares / judged), 0.25e-3);
    EXPECT_LT(largest, 2.4e-3);
    EXPECT_GT(fit->row_sigma_mm, 0.05e-3) << "the rows' own noise";
    EXPECT_LT(fit->row_sigma_mm, 1e-3);

    const SurfaceDeviation warm = deviation_of(fit->surface, data.points);
    EXPECT_EQ(warm.points, data.points.size());
    EXPECT_NEAR(warm.rms_mm, 1e-3, 0.1e-3) << "the points' noise";
    EXPECT_LT(warm.p95_mm, warm.p99_mm);
    EXPECT_LT(warm.p99_mm, warm.max_mm);
    EXPECT_LT(warm.max_mm, 8e-3);
    EXPECT_NEAR(warm.mean_mm, 0.0, 0.1e-3);
    EXPECT_LT(warm.newton_wrong + warm.newton_failures, warm.points / 20);
    EXPECT_LT(double(warm.newton_steps), 5.0 * double(warm.points));
    const std::vector<Vec3> some(data.points.begin(), data.points.begin() + 400);
    const SurfaceDeviation cold = deviation_of(fit->surface, some, false);
    EXPECT_GT(cold.newton_wrong + cold.newton_failures, 50U);
    EXPECT_GT(double(cold.newton_steps) / 400.0, double(warm.newton_steps) / double(warm.points));
}

TEST(SurfaceFit, AlignsTheEdgesOfTheRows) {
    const families::TwistedBlade blade(families::Family::turbine, 6);
    const MeasuredRows data = measured_rows(blade, 12);
    const RowAlignment alignment(features_of(data.rows));
    Eigen::MatrixX2d line(data.rows.size(), 2);
    Eigen::VectorXd from_camber_mm(data.rows.size());
    for (std::size_t k = 0; k < data.rows.size(); ++k) {
        const auto outline = blade.outline(data.rows[k].z_mm());
        const double apart = (data.rows[k].at(alignment.arc_length(k, 0.0)) - outline.le().nose).norm();
        EXPECT_LT(apart, 0.3) << "the nose by the sides' normals is near the camber line's end";
        line.row(static_cast<Eigen::Index>(k)) << 1.0, data.rows[k].z_mm();
        from_camber_mm[static_cast<Eigen::Index>(k)] = apart;
        double last = alignment.arc_length(k, 0.0);
        for (int i = 1; i <= 500; ++i) {
            const double s = alignment.arc_length(k, alignment.period() * i / 500);
            EXPECT_GT(s, last);
            last = s;
        }
        EXPECT_NEAR(last, alignment.arc_length(k, 0.0) + data.rows[k].length_mm(), 1e-9);
    }
    // The blade tapers, and its edge with it: the places go from 0.254 to 0.222 mm. Where noses were the nearest points
    // of contours they were 0.0096 mm off a line, and, by chance, only 0.025 mm apart.
    const Eigen::VectorXd off_mm = from_camber_mm - line * line.colPivHouseholderQr().solve(from_camber_mm);
    EXPECT_LT(off_mm.lpNorm<Eigen::Infinity>(), 0.007) << "at the same place on all rows";
}

/// Rows that differ by more than their noise, and one with waves that the row which the knots follow does not have.
TEST(SurfaceFit, ThroughRowsKeepsTheFormOfEach) {
    const families::TwistedBlade blade(families::Family::compressor, 6);
    constexpr std::size_t wavy = 6;
    constexpr double swell = 1.002, wave_mm = 0.02, turns = 40.0;
    const auto change = [&](std::size_t row, std::vector<Vec2>& points) {
        Vec2 middle = Vec2::Zero();
        for (const Vec2& p : points)
            middle += p / static_cast<double>(points.size());
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (row % 2 == 1) points[i] = middle + swell * (points[i] - middle);
            const double share = static_cast<double>(i) / static_cast<double>(points.size());
            if (row == wavy && share > 0.15 && share < 0.35)
                points[i].y() += wave_mm * std::sin(2.0 * std::numbers::pi * turns * share);
        }
    };
    const MeasuredRows data = measured_rows(blade, 8, change);
    std::vector<Vec3> on_rows;
    for (const SurfaceRow& row : data.rows)
        for (int k = 0; k < 700; ++k) {
            const Vec2 p = row.at(row.length_mm() * k / 700.0);
            on_rows.emplace_back(p.x(), p.y(), row.z_mm());
        }
    const auto smooth = fit_surface(data.rows), through = fit_surface(data.rows, {.through_rows = true});
    ASSERT_TRUE(smooth && through);
    EXPECT_GT(deviation_of(smooth->surface, on_rows).max_mm, 10e-3);
    EXPECT_LT(deviation_of(through->surface, on_rows).max_mm, 0.3e-3);
    EXPECT_TRUE(through->strays.empty());
}

/// Beside the end that is nearest, but behind the nose, a joint is that of the other end.
TEST(RowFeatures, AJointBelongsToItsOwnSideOfTheNose) {
    RowFeatures row;
    row.length_mm = 100.0;
    row.s_mm = {1.0, 4.0, 48.0, 50.0, 57.0, 98.0};
    const std::vector<RowJoint> found{{51.0, 0.01, 0.5}, {47.5, 0.01, 0.2}, {0.5, 0.01, 0.3}, {25.0, 0.01, 9.0}};
    row.set_joints(found);
    ASSERT_TRUE(row.joints[RowFeatures::te_end] && row.joints[RowFeatures::te_begin]);
    EXPECT_EQ(row.joints[RowFeatures::te_end]->s_mm, 51.0);
    EXPECT_EQ(row.joints[RowFeatures::te_begin]->s_mm, 47.5);
    ASSERT_TRUE(row.joints[RowFeatures::le_begin]);
    EXPECT_EQ(row.joints[RowFeatures::le_begin]->s_mm, 0.5) << "over the start of the curve";
    EXPECT_FALSE(row.joints[RowFeatures::le_end]);
}

TEST(SurfaceFit, RefusesRowsThatMakeNoSurface) {
    const families::TwistedBlade blade(families::Family::turbine, 7);
    std::vector<SurfaceRow> rows = measured_rows(blade, 4).rows;
    EXPECT_FALSE(fit_surface({}));
    EXPECT_FALSE(fit_surface(std::span(rows).first(1)));
    EXPECT_TRUE(fit_surface(std::span(rows).first(2)));
    EXPECT_TRUE(fit_surface(std::span(rows).first(3)));
    EXPECT_FALSE(fit_surface(rows, {.beyond_mm = std::nan("")}));
    EXPECT_FALSE(fit_surface(rows, {.span_turn_rad = 0.0}));
    const std::vector<SurfaceRow> again{rows[0], rows[0]};
    EXPECT_NE(fit_surface(again).error().message.find("again"), std::string::npos);
    const std::vector<SurfaceRow> crossing{rows[0], rows[2], rows[1]};
    EXPECT_NE(fit_surface(crossing).error().message.find("cross"), std::string::npos);
    EXPECT_FALSE(SurfaceRow::make(rows[0].smooth(), std::numeric_limits<double>::infinity(), 0.0));
    EXPECT_FALSE(SurfaceRow::make(rows[0].smooth(), 1.0, -1.0));
    EXPECT_EQ(deviation_of(fit_surface(rows)->surface, {}).points, 0U);
}

}  // namespace
}  // namespace cmm::fitting
