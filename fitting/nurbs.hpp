// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/bspline.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A plane NURBS curve (seed 000, eq 6-7): the central projection of a B-spline in homogeneous coordinates
/// (w x, w y, w), whose knots, insertion and removal it shares. Clamped or closed. Value type, any thread.
class NurbsCurve {
  public:
    /// Errors: fit_not_evaluable (those of BSpline::make; a weight that is not positive).
    static core::Result<NurbsCurve> make(BSpline<3> homogeneous);

    Vec2 position(double u) const;
    /// With the first two derivatives by u (Piegl and Tiller 1997, eq 4.8).
    Jet jet(double u) const;

    core::Result<NurbsCurve> with_knot(double u) const;
    struct Reduced;
    /// Without the knots that the tolerance does not need; `error_mm` bounds the distance of equal parameters (Piegl
    /// and Tiller 1997, eq 5.30).
    Reduced reduced(double tolerance_mm) const;

    const BSpline<3>& homogeneous() const { return homogeneous_; }
    const std::vector<double>& knots() const { return homogeneous_.knots(); }
    std::vector<Vec2> controls() const;
    std::vector<double> weights() const;

  private:
    explicit NurbsCurve(BSpline<3> homogeneous) : homogeneous_(std::move(homogeneous)) {}
    BSpline<3> homogeneous_;
};

struct NurbsCurve::Reduced {
    NurbsCurve curve;
    double error_mm = 0.0;
};

/// How an interpolating curve ends. A tangent is a direction: its length is set to the speed of the chord parameter.
/// The data weights have the end slope `weight_slope` (by u) there; at the other ends they follow the same condition
/// as the points.
struct NurbsEnd {
    SplineEnd::Kind kind = SplineEnd::Kind::natural;
    Vec2 tangent = Vec2::Zero();
    double weight_slope = 0.0;

    static NurbsEnd along(const Vec2& tangent, double weight_slope = 0.0) {
        return {SplineEnd::Kind::derivative, tangent, weight_slope};
    }
    static NurbsEnd not_a_knot() { return {SplineEnd::Kind::not_a_knot, Vec2::Zero(), 0.0}; }
};

/// The cubic NURBS through q_1 ... q_n at cumulative chord lengths over [0, 1] (seed 000, eq 8-14, with the corrections
/// of docs/theory.md). `weights` are the data weights (empty: all 1); with equal weights the result is the non-rational
/// C2 spline. Errors: fit_not_evaluable (fewer than 2 points, repeated or not finite points, weights <= 0, weights
/// whose control weights are not positive, a tangent of length zero).
core::Result<NurbsCurve> interpolate_nurbs(std::span<const Vec2> points, std::span<const double> weights,
                                           const NurbsEnd& start, const NurbsEnd& end);

/// The closed one; the last point is not a repetition of the first. Errors as above, and fewer than 4 points.
core::Result<NurbsCurve> interpolate_closed_nurbs(std::span<const Vec2> points, std::span<const double> weights);

}  // namespace cmm::fitting
