// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/arc_length.hpp"
#include "fitting/row_features.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// A closed row of a surface: the smooth curve through its points in the plane z = const.
class SurfaceRow {
  public:
    /// LE and TE are sought on the parallel curve `ball_radius_mm` inside (0: on the curve itself), near the hints
    /// where given (those of the row below). Errors: fit_not_evaluable (no two edges, z not finite).
    static core::Result<SurfaceRow> make(SmoothCurve smooth, double z_mm, double ball_radius_mm,
                                         const std::optional<Vec2>& le_hint = {},
                                         const std::optional<Vec2>& te_hint = {});

    double z_mm() const { return features_.z_mm; }
    double length_mm() const { return features_.length_mm; }
    const SmoothCurve& smooth() const { return smooth_; }
    const RowFeatures& features() const { return features_; }
    const Vec2& le() const { return le_; }
    const Vec2& te() const { return te_; }
    /// The point at an arc length (along the curve to place_near), any turn; its parameter on the curve, and back.
    Vec2 at(double s_mm) const;
    double parameter(double s_mm) const;
    double arc_length(double t) const;
    /// The row with a curve that begins at the arc length `begin_mm` of this one and hardly differs otherwise.
    SurfaceRow with(SmoothCurve smooth, double begin_mm) const;

  private:
    double in_first_turn(double s_mm) const;
    void find_joints();

    SmoothCurve smooth_;
    ArcLength arc_;
    RowFeatures features_;
    Vec2 le_, te_;
};

/// With noses where the edges face the way that the edges of all rows do, to their chords: what a round edge tells of
/// its own nose is next to nothing, and one beside a dent lies elsewhere.
std::vector<RowFeatures> features_of(std::span<const SurfaceRow> rows);

/// Of the rows at a quarter, half and three quarters of the height that whose curve has neither the most nor the fewest
/// spans: one of them may have a dent, which asks for more. At least one row.
std::size_t usual_row(std::span<const SurfaceRow> rows);

}  // namespace cmm::fitting
