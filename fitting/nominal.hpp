// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "core/error.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/section.hpp"

namespace cmm::fitting {

struct NominalOptions {
    std::optional<Vec2> le_hint;  ///< a point near the LE; otherwise the edge with the larger radius
    std::optional<Vec2> te_hint;
};

/// A stretch of a nominal curve by arc length, counter-clockwise; to_mm may exceed the length (wrap).
struct ZoneSpan {
    double from_mm = 0.0, to_mm = 0.0;
};

/// A nominal section: its curve, edges and zones, found by the same code as on a measured contour. Immutable, any
/// thread.
class NominalSection {
  public:
    const ClosedCurve& curve() const { return curve_; }
    Zone zone_at(double s_mm) const;
    Zone side_at(double s_mm) const;         ///< suction or pressure, parted at the noses
    double le_mm() const { return le_mm_; }  ///< arc length of the LE nose
    double te_mm() const { return te_mm_; }
    Vec2 le_point() const { return curve_.position(le_mm_); }
    Vec2 te_point() const { return curve_.position(te_mm_); }
    const ZoneSpan& le_span() const { return le_; }
    const ZoneSpan& te_span() const { return te_; }
    ZoneSpan span_of(Zone zone) const;
    /// Mean radius over the sharpest 120 degrees of the edge.
    double le_radius_mm() const { return le_radius_; }
    double te_radius_mm() const { return te_radius_; }

  private:
    friend core::Result<NominalSection> analyse_nominal(std::span<const Vec2> points, const NominalOptions& options);
    bool inside(const ZoneSpan& span, double s_mm) const;

    ClosedCurve curve_;
    ZoneSpan le_, te_;
    double le_mm_ = 0.0, te_mm_ = 0.0, le_radius_ = 0.0, te_radius_ = 0.0;
    bool suction_after_le_ = true;
};

/// Points on the part, in order, either direction, repeated first point allowed, sparse edges allowed (5 points on an
/// arc). Errors: fit_not_evaluable (see ClosedCurve::through, find_edges).
core::Result<NominalSection> analyse_nominal(std::span<const Vec2> points, const NominalOptions& options = {});

}  // namespace cmm::fitting
