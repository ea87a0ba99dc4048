// SPDX-License-Identifier: Apache-2.0
/// Surfaces through rows of unequal length against exact truth.
#include "fitting/surface_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <span>

#include "core/rng.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

struct MeasuredRows {
    std::vector<Vec3> points;
    std::vector<SurfaceRow> rows;
};

/// Rows of 340 to 460 points on the part itself, 1 um noise along the normal.
MeasuredRows measured_rows(const families::TwistedBlade& blade, std::size_t count) {
    MeasuredRows result;
    std::optional<Vec2> le, te;
    for (std::size_t k = 0; k < count; ++k) {
        const double z = 2 + (blade.height() - 4) * double(k) / double(count - 1);
        families::ScanOptions scanning;
        scanning.ball_mm = 0.0;
        scanning.bad_share = 0.0;
        scanning.points = 340 + k * 37 % 121;
        scanning.seed = 1 + k;
        const auto row = families::scan_rows(blade, 1, z, z, scanning).rows[0];
        std::vector<Vec2> plane;
        for (const Vec3& p : row)
            plane.push_back(p.head<2>());
        if (!le) {
            le = blade.outline(z).le().nose;
            te = blade.outline(z).te().nose;
        }
        auto made = SurfaceRow::make(smooth_closed(plane).value(), z, 0.0, le, te);
        EXPECT_TRUE(made);
        le = made->le();
        te = made->te();
        result.rows.push_back(std::move(*made));
        result.points.insert(result.points.end(), row.begin(), row.end());
    }
    return result;
}

/// Where an arc meets a side; single rows know the place to some hundredths of a millimetre, or not at all.
TEST(SurfaceRows, HaveTheirJointsInCommon) {
    const families::TwistedBlade blade(families::Family::turbine, 3);
    const MeasuredRows data = measured_rows(blade, 24);
    const auto settled = settle_joints(data.rows);
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
        for (const auto& joint : data.rows[k].joints())
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

    // A single row has nobody to ask.
    const auto alone = settle_joints(std::span(data.rows).first(1));
    ASSERT_EQ(alone.size(), 1U);
    EXPECT_EQ(alone[0].smooth().joints.size(), data.rows[0].smooth().joints.size());
    EXPECT_TRUE(settle_joints({}).empty());
}

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
    const RowAlignment alignment(data.rows);
    double nearest = 1.0, farthest = 0.0;
    for (std::size_t k = 0; k < data.rows.size(); ++k) {
        const auto outline = blade.outline(data.rows[k].z_mm());
        const double apart = (data.rows[k].at(alignment.arc_length(k, 0.0)) - outline.le().nose).norm();
        EXPECT_LT(apart, 0.3) << "the nose by the sides' normals is near the camber line's end";
        nearest = std::min(nearest, apart);
        farthest = std::max(farthest, apart);
        double last = alignment.arc_length(k, 0.0);
        for (int i = 1; i <= 500; ++i) {
            const double s = alignment.arc_length(k, alignment.period() * i / 500);
            EXPECT_GT(s, last);
            last = s;
        }
        EXPECT_NEAR(last, alignment.arc_length(k, 0.0) + data.rows[k].length_mm(), 1e-9);
    }
    EXPECT_LT(farthest - nearest, 0.03) << "at the same place on all rows";
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
