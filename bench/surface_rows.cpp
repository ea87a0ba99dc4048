// SPDX-License-Identifier: Apache-2.0
#include "bench/surface_rows.hpp"

#include <algorithm>
#include <utility>

#include "fitting/closed_curve.hpp"
#include "fitting/least_squares.hpp"

namespace cmm::bench {

using namespace fitting;

namespace {

constexpr std::size_t points_of_a_span = 3;
constexpr int projected_rounds = 1;  // a second changes the errors' rms by less than a nanometre

/// A step of Newton's method from where the points were before; they stay in their order and within the period.
void project(const PiecewiseCubic& curve, const std::vector<Vec2>& points, std::vector<double>& t) {
    double last = curve.front();
    std::size_t span = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        double at = t[i];
        span = curve.span_of(at, span);
        const Jet jet = curve.jet_in(span, at);
        const double squared = jet.d1.squaredNorm() - (points[i] - jet.position).dot(jet.d2);
        const double step = (points[i] - jet.position).dot(jet.d1) / squared;
        last = t[i] = std::clamp(t[i] + step, last, curve.front() + curve.period());
    }
}

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

SmoothCurve MeasuredRows::least_squares(const std::vector<Vec2>& row, int projections) const {
    const std::vector<double> chords = chord_parameters(row, true);
    std::vector<double> t(chords.begin(), chords.end() - 1), x, y, breaks;
    for (std::size_t i = 0; i < row.size(); ++i) {
        x.push_back(row[i].x());
        y.push_back(row[i].y());
        if (i % points_of_a_span == 0 && i + points_of_a_span <= row.size()) breaks.push_back(chords[i]);
    }
    breaks.push_back(chords.back());
    LeastSquaresSpline spline;
    SmoothCurve smooth;
    for (int round = 0;; ++round) {
        const bool solved = spline.set_knots(breaks, true) && spline.add({t, x, y}) && spline.solve();
        smooth.curve = solved ? spline.curve() : PiecewiseCubic();
        if (!solved || round == projections) return smooth;
        project(smooth.curve, row, t);
    }
}

std::vector<SurfaceRow> MeasuredRows::fitted(RowCurve kind) const {
    std::vector<SurfaceRow> rows;
    rows.reserve(plane.size());
    for (std::size_t k = 0; k < plane.size(); ++k) {
        SmoothCurve smooth = kind == RowCurve::by_evidence
                                 ? smooth_closed(plane[k]).value()
                                 : least_squares(plane[k], kind == RowCurve::projected ? projected_rounds : 0);
        rows.push_back(SurfaceRow::make(std::move(smooth), heights[k], 0.0, k > 0 ? rows.back().le() : le_,
                                        k > 0 ? rows.back().te() : te_)
                           .value());
    }
    return rows;
}

}  // namespace cmm::bench
