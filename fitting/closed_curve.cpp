// SPDX-License-Identifier: Apache-2.0
#include "fitting/closed_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

// Gauss-Legendre, 4 points on [0, 1]: exact to 1e-9 of a piece that turns less than half a radian.
constexpr std::array<double, 4> gauss_at{0.069431844202973712, 0.330009478207571868, 0.669990521792428132,
                                         0.930568155797026288};
constexpr std::array<double, 4> gauss_weight{0.173927422568726929, 0.326072577431273071, 0.326072577431273071,
                                             0.173927422568726929};

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

ClosedCurve::ClosedCurve(PiecewiseCubic spline) : spline_(std::move(spline)) {
    const std::size_t n = spline_.spans();
    const auto& breaks = spline_.breaks();
    arc_.assign(n + 1, 0.0);
    const Vec2 origin = spline_.pieces().front()[0];
    for (std::size_t k = 0; k < n; ++k) {
        arc_[k + 1] = arc_[k] + piece_length(k, breaks[k + 1]);
        const double h = breaks[k + 1] - breaks[k];
        for (std::size_t g = 0; g < gauss_at.size(); ++g) {
            const Jet jet = spline_.jet_in(k, breaks[k] + gauss_at[g] * h);
            area_ += 0.5 * gauss_weight[g] * h * cross(jet.position - origin, jet.d1);
        }
    }
    first_span_.resize(n + 1);
    for (std::size_t k = 0, span = 0; k <= n; ++k) {
        const double s = length() * static_cast<double>(k) / static_cast<double>(n);
        while (span + 1 < n && arc_[span + 1] <= s)
            ++span;
        first_span_[k] = span;
    }
}

double ClosedCurve::piece_length(std::size_t span, double t) const {
    const double from = spline_.breaks()[span], h = t - from;
    double sum = 0.0;
    for (std::size_t g = 0; g < gauss_at.size(); ++g)
        sum += gauss_weight[g] * spline_.jet_in(span, from + gauss_at[g] * h).speed();
    return sum * h;
}

double ClosedCurve::wrap(double s_mm) const {
    const double total = length();
    if (s_mm >= 0.0 && s_mm < total) return s_mm;
    const double wrapped = s_mm - std::floor(s_mm / total) * total;
    return wrapped < total && wrapped >= 0.0 ? wrapped : 0.0;
}

std::size_t ClosedCurve::span_at(double& s_mm) const {
    s_mm = wrap(s_mm);
    const std::size_t n = spline_.spans();
    const auto bucket = std::min(n, static_cast<std::size_t>(s_mm / length() * static_cast<double>(n)));
    std::size_t span = first_span_[bucket];
    while (span > 0 && arc_[span] > s_mm)
        --span;
    while (span + 1 < n && arc_[span + 1] <= s_mm)
        ++span;
    return span;
}

double ClosedCurve::parameter_at(double s_mm) const {
    const std::size_t span = span_at(s_mm);
    const double from = spline_.breaks()[span], to = spline_.breaks()[span + 1];
    const double piece = arc_[span + 1] - arc_[span], wanted = s_mm - arc_[span];
    double t = piece > 0.0 ? from + (to - from) * wanted / piece : from;
    for (int step = 0; step < 4; ++step) {
        const double speed = spline_.jet_in(span, t).speed();
        if (!(speed > 0.0)) break;
        const double correction = (wanted - piece_length(span, t)) / speed;
        t = std::clamp(t + correction, from, to);
        if (std::abs(correction) < 1e-10 * (to - from)) break;
    }
    return t;
}

double ClosedCurve::arc_length_at(double t) const {
    const std::size_t span = spline_.span_of(t);
    return arc_[span] + piece_length(span, t);
}

CurvePoint ClosedCurve::evaluate(double s_mm) const {
    const Jet jet = spline_.jet(parameter_at(s_mm));
    const Vec2 tangent = jet.tangent();
    return {jet.position, tangent, fitting::right_normal(tangent), jet.curvature()};
}

Vec2 ClosedCurve::position(double s_mm) const {
    return spline_.jet(parameter_at(s_mm)).position;
}

bool ClosedCurve::refine(const Vec2& point, Foot& foot) const {
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

ClosedCurve::Foot ClosedCurve::search(const Vec2& point) const {
    const auto& pieces = spline_.pieces();
    const auto& breaks = spline_.breaks();
    Foot best{0, breaks[0], std::numeric_limits<double>::infinity()};
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const double squared = (pieces[k][0] - point).squaredNorm();
        if (squared < best.squared) best = {k, breaks[k], squared};
    }
    Foot local = best;
    if (refine(point, local) && local.squared <= best.squared) best = local;
    // No point of a piece is nearer than the nearer end less half the piece's length.
    double distance = std::sqrt(best.squared);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const std::size_t next = (k + 1) % pieces.size();
        const double half = 0.5 * (arc_[k + 1] - arc_[k]), bound = distance + half;
        if (std::min((pieces[k][0] - point).squaredNorm(), (pieces[next][0] - point).squaredNorm()) > bound * bound)
            continue;
        for (const double part : {0.0, 0.25, 0.5, 0.75}) {
            const double t = breaks[k] + part * (breaks[k + 1] - breaks[k]);
            local = {k, t, 0.0};
            const double start = (spline_.jet_in(k, t).position - point).squaredNorm();
            if (refine(point, local) && local.squared < best.squared) best = local;
            if (start < best.squared) best = {k, t, start};
        }
        distance = std::sqrt(best.squared);
    }
    return best;
}

ClosestPoint ClosedCurve::closest(const Vec2& point, std::optional<double> hint_mm) const {
    Foot foot{};
    bool found = false;
    if (hint_mm) {
        double s = *hint_mm;
        foot.span = span_at(s);
        const double from = spline_.breaks()[foot.span], to = spline_.breaks()[foot.span + 1];
        foot.t = from + (to - from) * (s - arc_[foot.span]) / std::max(arc_[foot.span + 1] - arc_[foot.span], 1e-300);
        const double start = (spline_.jet_in(foot.span, foot.t).position - point).squaredNorm();
        found = refine(point, foot) && foot.squared <= start * (1.0 + 1e-12);
    }
    if (!found) foot = search(point);
    const Jet jet = spline_.jet_in(foot.span, foot.t);
    const Vec2 r = point - jet.position;
    const double side = r.dot(fitting::right_normal(jet.d1));
    return {arc_[foot.span] + piece_length(foot.span, foot.t), std::copysign(r.norm(), side), jet.position};
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
