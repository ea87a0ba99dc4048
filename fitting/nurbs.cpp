// SPDX-License-Identifier: Apache-2.0
#include "fitting/nurbs.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "fitting/bspline_pieces.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

core::Status check(std::span<const Vec2> points, std::span<const double> weights, std::size_t least) {
    if (points.size() < least)
        return core::fail(ErrorCode::fit_not_evaluable, "NURBS: needs " + std::to_string(least) + " points");
    if (!weights.empty() && weights.size() != points.size())
        return core::fail(ErrorCode::fit_not_evaluable, "NURBS: as many weights as points are needed");
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!is_finite(points[i]) || (i > 0 && !((points[i] - points[i - 1]).norm() > 0.0)))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "NURBS: point " + std::to_string(i) + " repeats or is not finite");
        if (!weights.empty() && !(weights[i] > 0.0 && std::isfinite(weights[i])))
            return core::fail(ErrorCode::fit_not_evaluable, "NURBS: weight " + std::to_string(i) + " is not positive");
    }
    return {};
}

/// Eq 8 over [0, 1], the sum running over the chords that exist. Fails where one vanishes beside the whole.
core::Result<std::vector<double>> unit_parameters(std::span<const Vec2> points, bool closed) {
    std::vector<double> t = chord_parameters(points, closed);
    const double total = t.back();
    for (double& u : t)
        u /= total;
    t.back() = 1.0;
    for (std::size_t i = 1; i < t.size(); ++i)
        if (!(t[i] > t[i - 1]))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "NURBS: point " + std::to_string(i % points.size()) + " repeats the one before");
    return t;
}

/// Data (w x, w y) and (w, 0): each is interpolated as a plane curve on the same knots.
struct Homogeneous {
    std::vector<Vec2> weighted, weight;
};
Homogeneous homogeneous_data(std::span<const Vec2> points, std::span<const double> weights) {
    Homogeneous data;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double w = weights.empty() ? 1.0 : weights[i];
        data.weighted.push_back(w * points[i]);
        data.weight.emplace_back(w, 0.0);
    }
    return data;
}

core::Result<NurbsCurve> joined(const PiecewiseCubic& weighted, const PiecewiseCubic& weight) {
    constexpr double all_simple = std::numeric_limits<double>::infinity();  // interpolants are C2
    const auto xy = to_bspline(weighted, all_simple), w = to_bspline(weight, all_simple);
    if (!xy) return tl::unexpected(xy.error());
    if (!w) return tl::unexpected(w.error());
    std::vector<Eigen::Vector3d> controls;
    for (std::size_t j = 0; j < xy->controls().size(); ++j)
        controls.emplace_back(xy->controls()[j].x(), xy->controls()[j].y(), w->controls()[j].x());
    auto curve = BSpline<3>::make(3, xy->knots(), std::move(controls), xy->closed());
    if (!curve) return tl::unexpected(curve.error());
    return NurbsCurve::make(std::move(*curve));
}

/// (w q)' = w' q + w q' with the tangent's length set to the speed of the chord parameter over [0, 1] (eq 10-14).
SplineEnd weighted_end(const NurbsEnd& end, const Vec2& q, double w, double speed) {
    if (end.kind != SplineEnd::Kind::derivative) return {end.kind, Vec2::Zero()};
    return SplineEnd::derivative(end.weight_slope * q + w * speed * end.tangent.normalized());
}
SplineEnd weight_end(const NurbsEnd& end) {
    return {end.kind, Vec2(end.weight_slope, 0.0)};
}

}  // namespace

core::Result<NurbsCurve> NurbsCurve::make(BSpline<3> homogeneous) {
    for (std::size_t j = 0; j < homogeneous.controls().size(); ++j)
        if (!(homogeneous.controls()[j].z() > 0.0))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "NURBS: the weight of control " + std::to_string(j) + " is not positive");
    return NurbsCurve(std::move(homogeneous));
}

Vec2 NurbsCurve::position(double u) const {
    return homogeneous_.position(u).hnormalized();
}

Jet NurbsCurve::jet(double u) const {
    const auto h = homogeneous_.derivatives(u, 2);
    const double w = h[0].z();
    const Vec2 c = h[0].head<2>() / w;
    const Vec2 d1 = (h[1].head<2>() - h[1].z() * c) / w;
    return {c, d1, (h[2].head<2>() - 2.0 * h[1].z() * d1 - h[2].z() * c) / w};
}

core::Result<NurbsCurve> NurbsCurve::with_knot(double u) const {
    auto finer = homogeneous_.with_knot(u);
    if (!finer) return tl::unexpected(finer.error());
    return NurbsCurve(std::move(*finer));
}

NurbsCurve::Reduced NurbsCurve::reduced(double tolerance_mm) const {
    if (!(tolerance_mm > 0.0)) return {*this, 0.0};
    double least = std::numeric_limits<double>::infinity(), farthest = 0.0;
    for (const auto& control : homogeneous_.controls()) {
        least = std::min(least, control.z());
        farthest = std::max(farthest, control.hnormalized().norm());
    }
    // New weights may come out negative, new controls farther away: then less is allowed.
    double allowed = tolerance_mm * least / (1.0 + farthest);
    for (int attempt = 0; attempt < 20; ++attempt) {
        auto coarser = homogeneous_.reduced(allowed);
        bool positive = true;
        double reach = farthest;
        for (const auto& control : coarser.curve.controls()) {
            positive = positive && control.z() > 0.0;
            if (positive) reach = std::max(reach, control.hnormalized().norm());
        }
        const double error = coarser.error * (1.0 + reach) / least;
        if (positive && error <= tolerance_mm) return {NurbsCurve(std::move(coarser.curve)), error};
        allowed = 0.5 * std::min(allowed, coarser.error);
    }
    return {*this, 0.0};
}

std::vector<Vec2> NurbsCurve::controls() const {
    std::vector<Vec2> points;
    for (const auto& control : homogeneous_.controls())
        points.push_back(control.hnormalized());
    return points;
}

std::vector<double> NurbsCurve::weights() const {
    std::vector<double> values;
    for (const auto& control : homogeneous_.controls())
        values.push_back(control.z());
    return values;
}

core::Result<NurbsCurve> interpolate_nurbs(std::span<const Vec2> points, std::span<const double> weights,
                                           const NurbsEnd& start, const NurbsEnd& end) {
    if (auto status = check(points, weights, 2); !status) return tl::unexpected(status.error());
    for (const NurbsEnd* e : {&start, &end})
        if (e->kind == SplineEnd::Kind::derivative && !(e->tangent.norm() > 0.0 && std::isfinite(e->weight_slope)))
            return core::fail(ErrorCode::fit_not_evaluable, "NURBS: an end tangent of length zero or not finite");
    const auto t = unit_parameters(points, false);
    if (!t) return tl::unexpected(t.error());
    const double speed = chord_parameters(points, false).back();
    const Homogeneous data = homogeneous_data(points, weights);
    const auto end_weight = [&](std::size_t i) { return data.weight[i].x(); };
    const std::size_t last = points.size() - 1;
    return joined(interpolate_open(data.weighted, *t, weighted_end(start, points[0], end_weight(0), speed),
                                   weighted_end(end, points[last], end_weight(last), speed)),
                  interpolate_open(data.weight, *t, weight_end(start), weight_end(end)));
}

core::Result<NurbsCurve> interpolate_closed_nurbs(std::span<const Vec2> points, std::span<const double> weights) {
    if (auto status = check(points, weights, 4); !status) return tl::unexpected(status.error());
    const auto t = unit_parameters(points, true);
    if (!t) return tl::unexpected(t.error());
    const Homogeneous data = homogeneous_data(points, weights);
    return joined(interpolate_periodic(data.weighted, *t), interpolate_periodic(data.weight, *t));
}

}  // namespace cmm::fitting
