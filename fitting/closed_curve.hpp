// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/arc_length.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A point of a closed curve at an arc length.
struct CurvePoint {
    Vec2 position = Vec2::Zero();
    Vec2 tangent = Vec2::UnitX();  ///< unit, counter-clockwise
    Vec2 normal = -Vec2::UnitY();  ///< unit, outward
    double curvature = 0.0;        ///< 1/mm, positive on convex parts
};

/// Where a curve is nearest to a point.
struct ClosestPoint {
    double s_mm = 0.0;         ///< arc length of the foot
    double distance_mm = 0.0;  ///< signed: positive outside, negative in the material
    Vec2 foot = Vec2::Zero();
    Vec2 normal = Vec2::Zero();  ///< of the curve there, unit, outward
    CurvePlace place = {};       ///< the same as s_mm
};

/// A closed C2 curve, always counter-clockwise, by arc length in [0, length): the periodic cubic spline through given
/// points (cumulative chord lengths), or any periodic PiecewiseCubic. Immutable after construction and
/// `note_clearances`, any thread, millimetres.
class ClosedCurve {
  public:
    ClosedCurve() = default;
    /// Consecutive duplicates and a last point equal to the first are dropped, clockwise points are reversed (s = 0
    /// stays at the first point). Errors: fit_not_evaluable (not finite, fewer than 4 different points, no area).
    static core::Result<ClosedCurve> through(std::span<const Vec2> points);
    /// A periodic spline that runs counter-clockwise already.
    explicit ClosedCurve(PiecewiseCubic spline);

    /// For a curve that many points near it will be compared with: ClosestPointIndex::note_clearances.
    void note_clearances() { nearest_.note_clearances(); }

    double length() const { return arc_.total(); }
    double area() const { return area_; }
    /// Whether the points came clockwise and were reversed.
    bool was_clockwise() const { return was_clockwise_; }

    CurvePoint evaluate(double s_mm) const;
    Vec2 position(double s_mm) const;
    double wrap(double s_mm) const;
    /// Arc length from a to b in the counter-clockwise sense, in [0, length).
    double ahead(double a_mm, double b_mm) const { return wrap(b_mm - a_mm); }

    /// The nearest point of the whole curve; with a hint the local minimum next to it, provided that it is nearer than
    /// the hinted point itself (otherwise the whole curve is searched).
    ClosestPoint closest(const Vec2& point, std::optional<double> hint_mm = {}) const;
    /// The same from a place that is known already, as that of a foot nearby.
    ClosestPoint closest(const Vec2& point, const CurvePlace& hint) const;

    /// The nearest points of the whole curve for many points, in any order: `feet` has room for as many. Points that
    /// jump about are visited cell by cell, so that random order costs little more than scan order.
    void closest(std::span<const Vec2> points, std::span<ClosestPoint> feet) const;

    /// Points of the parallel curve at a signed distance (positive: outwards), in steps of arc length <= max_step_mm.
    /// Loops are not trimmed: see offset.hpp.
    std::vector<Vec2> offset_points(double distance_mm, double max_step_mm) const;

    const PiecewiseCubic& spline() const { return spline_; }
    double parameter_at(double s_mm) const;
    double arc_length_at(double t) const;

  private:
    bool refine(const Vec2& point, CurveFoot& foot) const;
    ClosestPoint described(const Vec2& point, const CurveFoot& foot) const;

    PiecewiseCubic spline_;
    ArcLength arc_;
    ClosestPointIndex nearest_;
    double area_ = 0.0;
    bool was_clockwise_ = false;
};

}  // namespace cmm::fitting
