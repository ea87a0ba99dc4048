// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset.hpp"

#include <cmath>
#include <numbers>

#include "bench/bench.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/offset_spline.hpp"

namespace cmm::bench {
namespace {

using fitting::Vec2;

constexpr double ball_mm = 1.0;
constexpr double tolerance_mm = 1e-4;
constexpr std::size_t contour_points = 2000;
constexpr std::size_t check_points = 20'000;

/// A cambered profile of 60 mm chord in 120 pieces, its ends rounder than the ball.
fitting::PiecewiseCubic profile(double half_thickness_mm) {
    constexpr int pieces = 120;
    std::vector<Vec2> points;
    for (int i = 0; i < pieces; ++i) {
        const double t = 2.0 * std::numbers::pi * i / pieces, x = std::cos(t);
        points.emplace_back(30.0 * x, half_thickness_mm * std::sin(t) + 5.0 * (1.0 - x * x));
    }
    return fitting::ClosedCurve::through(points).value().spline();
}

void print_us(const std::string& what, const Spread& s, const std::string& target) {
    print(what, {s.low * 1e6, s.median * 1e6, s.high * 1e6}, "us", target);
}

void bench_one(const std::string& name, const fitting::PiecewiseCubic& source) {
    fitting::Offset offset;
    const auto contour = time_of(301, [&] { offset = fitting::offset_inwards(source, ball_mm, contour_points); });
    print_us("offset contour, " + name, contour,
             "50 us (" + std::to_string(offset.points.size()) + " points, " + std::to_string(offset.corners.size()) +
                 " corners)");
    fitting::OffsetSpline spline;
    const auto approximation = time_of(301, [&] { spline = fitting::offset_spline(source, -ball_mm, tolerance_mm); });
    print_us("offset as a spline to 0.1 um, " + name, approximation,
             "100 us (" + std::to_string(spline.curve.spans()) + " pieces)");
    const fitting::ClosedCurve curve(source);
    double worst = 0.0;
    for (std::size_t i = 0; i < check_points; ++i) {
        const double t = spline.curve.period() * static_cast<double>(i) / check_points;
        worst = std::max(worst, std::abs(std::abs(curve.closest(spline.curve.jet(t).position).distance_mm) - ball_mm));
    }
    const double bound_um = spline.error_mm * 1e3, true_um = worst * 1e3;
    print("  its true error, and the certified bound", {true_um, true_um, bound_um}, "um", "0.1 um");
}

}  // namespace

void bench_offsets() {
    bench_one("no loops", profile(9.0));
    bench_one("loops at both ends", profile(5.0));
}

}  // namespace cmm::bench
