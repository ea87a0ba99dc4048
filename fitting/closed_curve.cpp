// SPDX-License-Identifier: Apache-2.0
#include "fitting/closed_curve.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

/// Different consecutive points, without a repeated first point.
std::vector<Vec2> without_duplicates(std::span<const Vec2> points) {
    std::vector<Vec2> kept;
    kept.reserve(points.size());
    Vec2 low = points.front(), high = low;
    for (const Vec2& p : points) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const double least = 1e-9 * (high - low).norm();
    for (const Vec2& p : points)
        if (kept.empty() || (p - kept.back()).norm() > least) kept.push_back(p);
    while (kept.size() > 1 && (kept.front() - kept.back()).norm() <= least)
        kept.pop_back();
    return kept;
}

double polygon_area(const std::vector<Vec2>& points) {
    double twice = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
        twice += cross(points[i] - points[0], points[(i + 1) % points.size()] - points[0]);
    return 0.5 * twice;
}

/// Integral of the cross product of position and derivative over a piece of width h.
double swept(const PiecewiseCubic::Piece& piece, const Vec2& origin, double h) {
    const auto& [p, b, c, d] = piece;
    const Vec2 a = p - origin;
    return h * (cross(a, b) + h * (cross(a, c) + h * (cross(a, d) + cross(b, c) / 3.0 +
                                                      h * (cross(b, d) / 2.0 + h * cross(c, d) / 5.0))));
}

}  // namespace

core::Result<ClosedCurve> ClosedCurve::through(std::span<const Vec2> points) {
    for (std::size_t i = 0; i < points.size(); ++i)
        if (!is_finite(points[i]))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "closed curve: point " + std::to_string(i) + " is not finite");
    std::vector<Vec2> kept;
    if (!points.empty()) kept = without_duplicates(points);
    if (kept.size() < 4)
        return core::fail(ErrorCode::fit_not_evaluable,
                          "closed curve: needs 4 different points, got " + std::to_string(kept.size()));
    const double area = polygon_area(kept);
    if (area < 0.0) std::reverse(kept.begin() + 1, kept.end());
    auto parameters = chord_parameters(kept, true);
    if (std::abs(area) < 1e-9 * parameters.back() * parameters.back())
        return core::fail(ErrorCode::fit_not_evaluable, "closed curve: the points enclose no area");
    ClosedCurve curve(interpolate_periodic(kept, std::move(parameters)));
    curve.was_clockwise_ = area < 0.0;
    return curve;
}

ClosedCurve::ClosedCurve(PiecewiseCubic spline) : spline_(std::move(spline)), arc_(spline_), nearest_(spline_) {
    const auto& breaks = spline_.breaks();
    const Vec2 origin = spline_.pieces().front()[0];
    for (std::size_t k = 0; k < spline_.spans(); ++k)
        area_ += 0.5 * swept(spline_.pieces()[k], origin, breaks[k + 1] - breaks[k]);
}

double ClosedCurve::wrap(double s_mm) const {
    const double total = length();
    if (s_mm >= 0.0 && s_mm < total) return s_mm;
    const double wrapped = s_mm - std::floor(s_mm / total) * total;
    return wrapped < total && wrapped >= 0.0 ? wrapped : 0.0;
}

double ClosedCurve::parameter_at(double s_mm) const {
    return arc_.place(spline_, wrap(s_mm)).t;
}

double ClosedCurve::arc_length_at(double t) const {
    const std::size_t span = spline_.span_of(t);
    return arc_.at(spline_, {span, t});
}

CurvePoint ClosedCurve::evaluate(double s_mm) const {
    const CurvePlace place = arc_.place(spline_, wrap(s_mm));
    const Jet jet = spline_.jet_in(place.span, place.t);
    const Vec2 tangent = jet.tangent();
    return {jet.position, tangent, fitting::right_normal(tangent), jet.curvature()};
}

Vec2 ClosedCurve::position(double s_mm) const {
    const CurvePlace place = arc_.place(spline_, wrap(s_mm));
    return spline_.jet_in(place.span, place.t).position;
}

bool ClosedCurve::refine(const Vec2& point, CurveFoot& foot) const {
    double t = foot.t;
    std::size_t span = foot.span;
    const double mean = spline_.period() / static_cast<double>(spline_.spans());
    for (int step = 0; step < 12; ++step) {
        const Jet jet = spline_.jet_in(span, t);
        const Vec2 r = jet.position - point;
        const double slope = r.dot(jet.d1), v2 = jet.d1.squaredNorm();
        // Newton (seed 001, B2); where the distance is not convex, Gauss-Newton, which always goes downhill.
        const double newton = v2 + r.dot(jet.d2);
        double move = -slope / (newton > 0.1 * v2 ? newton : v2);
        move = std::clamp(move, -2.0 * mean, 2.0 * mean);
        foot = {span, t, r.squaredNorm()};
        if (std::abs(move) <= 1e-12 * spline_.period()) return true;
        t += move;
        span = spline_.span_of(t, span);
        if (std::abs(move) <= 1e-7 * mean) {
            foot = {span, t, (spline_.jet_in(span, t).position - point).squaredNorm()};
            return true;
        }
    }
    return false;
}

ClosestPoint ClosedCurve::described(const Vec2& point, const CurveFoot& foot) const {
    const Jet jet = spline_.jet_in(foot.span, foot.t);
    const CurvePlace place{foot.span, foot.t};
    const Vec2 r = point - jet.position, normal = jet.right_normal();
    return {arc_.at(spline_, place), std::copysign(r.norm(), r.dot(normal)), jet.position, normal, place};
}

ClosestPoint ClosedCurve::closest(const Vec2& point, std::optional<double> hint_mm) const {
    if (!hint_mm) return described(point, nearest_.closest(point));
    return closest(point, arc_.place(spline_, wrap(*hint_mm)));
}

ClosestPoint ClosedCurve::closest(const Vec2& point, const CurvePlace& hint) const {
    CurveFoot foot{hint.span, hint.t, 0.0};
    const double start = (spline_.jet_in(foot.span, foot.t).position - point).squaredNorm();
    if (!refine(point, foot) || foot.squared > start * (1.0 + 1e-12)) foot = nearest_.closest(point, hint.span);
    return described(point, foot);
}

void ClosedCurve::closest(std::span<const Vec2> points, std::span<ClosestPoint> feet) const {
    nearest_.for_each(points, [&](std::size_t i, const CurveFoot& foot) { feet[i] = described(points[i], foot); });
}

std::vector<Vec2> ClosedCurve::offset_points(double distance_mm, double max_step_mm) const {
    const auto count = std::max<std::size_t>(8, static_cast<std::size_t>(std::ceil(length() / max_step_mm)));
    std::vector<Vec2> points;
    points.reserve(count);
    for (std::size_t k = 0; k < count; ++k) {
        const CurvePoint p = evaluate(length() * static_cast<double>(k) / static_cast<double>(count));
        points.push_back(p.position + distance_mm * p.normal);
    }
    return points;
}

}  // namespace cmm::fitting
