// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "fitting/circle.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// An arc that replaces the curve between two parameters (to > from; may pass the period's end).
struct ArcPatch {
    Circle circle;
    double from = 0.0, to = 0.0;
};

/// Joins edge arcs and sides into one closed C2 curve (seed 000, A21). Where the paper bridges the gap or overlap with
/// a tangent and 3-4 inserted points, the points inserted here run from the curve over to the arc with a quintic weight
/// in a quarter of the patch at either end, so that a join always exists; the cubic spline through all of them is the
/// result. The curve outside the patches is reproduced exactly, and the parameter stays the same.
PiecewiseCubic join_arcs(const PiecewiseCubic& curve, std::span<const ArcPatch> patches);

}  // namespace cmm::fitting
