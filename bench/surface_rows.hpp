// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/surface.hpp"
#include "fitting/surface_rows.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::bench {

/// How a row's curve is made: by least squares on as many knots as a third of the points, at the points' chords or with
/// the points projected twice (seed 001, B12: iterated row curves); or as a section has it, a smoothing spline whose
/// strength, joints and knots follow from the points, which are projected in every round.
enum class RowCurve { at_chords, projected, by_evidence };

/// Rows of unequal length on a blade itself, 1 um noise along the normal.
struct MeasuredRows {
    MeasuredRows(const fitting::families::TwistedBlade& blade, std::size_t count, std::size_t mean_points);

    std::vector<fitting::SurfaceRow> fitted(RowCurve kind) const;

    std::vector<double> heights;
    std::vector<std::vector<fitting::Vec2>> plane;
    std::vector<fitting::Vec3> points;

  private:
    fitting::SmoothCurve least_squares(const std::vector<fitting::Vec2>& row, int projections) const;
    fitting::Vec2 le_, te_;  // of the lowest
};

}  // namespace cmm::bench
