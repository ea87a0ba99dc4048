// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/closed_curve.hpp"

namespace cmm::fitting {

/// A point of a parallel curve and where it comes from.
struct OffsetPoint {
    Vec2 position = Vec2::Zero();
    Vec2 normal = Vec2::Zero();  ///< unit, outward
    double t = 0.0;              ///< parameter on the source curve
};

struct Offset {
    std::vector<OffsetPoint> points;  ///< closed, counter-clockwise
    std::size_t trimmed = 0;          ///< points that were cut off with loops
};

/// The parallel curve at `radius` inwards, c - r n (seed 000, eq 15-17, on a counter-clockwise curve), at about `count`
/// points: three quarters of them evenly by arc length, the rest by turning. Points nearer than `radius` to the source
/// (loops where the radius exceeds the local radius of curvature, A24) are cut off. radius 0 samples the curve itself.
Offset offset_inwards(const ClosedCurve& curve, double radius_mm, std::size_t count);

}  // namespace cmm::fitting
