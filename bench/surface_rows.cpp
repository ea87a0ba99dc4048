// SPDX-License-Identifier: Apache-2.0
#include "bench/surface_rows.hpp"

#include <utility>

#include "fitting/closed_curve.hpp"
#include "fitting/least_squares.hpp"

namespace cmm::bench {

using namespace fitting;

namespace {

constexpr std::size_t points_of_a_span = 3;

}  // namespace

MeasuredRows::MeasuredRows(const families::TwistedBlade& blade, std::size_t count, std::size_t mean_points) {
    for (std::size_t k = 0; k < count; ++k) {
        const double z = 2 + (blade.height() - 4) * static_cast<double>(k) / static_cast<double>(count - 1);
        families::ScanOptions scanning;
        scanning.ball_mm = 0.0;
        scanning.bad_share = 0.0;
        scanning.points = mean_points * (85 + k * 37 % 31) / 100;
        scanning.seed = 1 + k;
        const families::BladeRows scanned = families::scan_rows(blade, 1, z, z, scanning);
        heights.push_back(z);
        plane.emplace_back();
        for (const Vec3& p : scanned.rows[0]) {
            points.push_back(p);
            plane.back().push_back(p.head<2>());
        }
    }
    le_ = blade.outline(heights[0]).le().nose;
    te_ = blade.outline(heights[0]).te().nose;
}

SmoothCurve MeasuredRows::at_chords(const std::vector<Vec2>& row) const {
    const std::vector<double> chords = chord_parameters(row, true);
    std::vector<double> x, y, breaks;
    for (std::size_t i = 0; i < row.size(); ++i) {
        x.push_back(row[i].x());
        y.push_back(row[i].y());
        if (i % points_of_a_span == 0 && i + points_of_a_span <= row.size()) breaks.push_back(chords[i]);
    }
    breaks.push_back(chords.back());
    SmoothCurve smooth;
    smooth.curve = fit_fixed_knots({std::span(chords).first(row.size()), x, y}, breaks, true).value();
    return smooth;
}

std::vector<SurfaceRow> MeasuredRows::fitted(bool corrected) const {
    std::vector<SurfaceRow> rows;
    rows.reserve(plane.size());
    for (std::size_t k = 0; k < plane.size(); ++k) {
        SmoothCurve smooth = corrected ? smooth_closed(plane[k]).value() : at_chords(plane[k]);
        rows.push_back(SurfaceRow::make(std::move(smooth), heights[k], 0.0, k > 0 ? rows.back().le() : le_,
                                        k > 0 ? rows.back().te() : te_)
                           .value());
    }
    return rows;
}

}  // namespace cmm::bench
