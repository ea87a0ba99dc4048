// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/surface.hpp"
#include "fitting/surface_rows.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::bench {

/// Rows of unequal length on a blade itself, 1 um noise along the normal.
struct MeasuredRows {
    MeasuredRows(const fitting::families::TwistedBlade& blade, std::size_t count, std::size_t mean_points);

    /// The rows' curves: smoothing splines whose points are projected anew in every round; or least squares on as many
    /// knots as a third of the points, at the points' chords.
    std::vector<fitting::SurfaceRow> fitted(bool corrected) const;

    std::vector<double> heights;
    std::vector<std::vector<fitting::Vec2>> plane;
    std::vector<fitting::Vec3> points;

  private:
    fitting::SmoothCurve at_chords(const std::vector<fitting::Vec2>& row) const;
    fitting::Vec2 le_, te_;  // of the lowest
};

}  // namespace cmm::bench
