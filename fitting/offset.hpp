// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/parallel_curve.hpp"

namespace cmm::fitting {

/// Where a loop was cut off: the two branches that meet and the part of the source between them, which the parallel
/// curve does not show (a ball of that radius does not reach it).
struct OffsetCorner {
    Vec2 position = Vec2::Zero();
    double from = 0.0, to = 0.0;  ///< source parameters that are cut off; to < from: over the period's end
};

/// Exact points of a parallel curve, closed, counter-clockwise.
struct Offset {
    /// A corner is one of them, with the normal that halves the angle between those of its branches.
    std::vector<OffsetPoint> points;
    std::vector<OffsetCorner> corners;
};

/// The curve c + d n parallel to a closed counter-clockwise curve without crossings (n: outward normal; d > 0 outwards;
/// seed 000, eq 15-17) at about `count` points: three quarters of them evenly by length, the rest by turning. Loops are
/// cut off exactly where their branches meet, both local ones (|d| above a radius of curvature, A24) and those of
/// opposite branches; of several closed parts the one with the largest area is taken. A corner of c is rounded by the
/// arc of radius |d| where the parallel curve would gape. Empty: nothing of the curve is as far away as |d|.
Offset offset_curve(const PiecewiseCubic& source, double distance_mm, std::size_t count);

/// From ball centres to the part: offset_curve at -radius.
inline Offset offset_inwards(const PiecewiseCubic& centres, double radius_mm, std::size_t count) {
    return offset_curve(centres, -radius_mm, count);
}

/// What the 2-D offset does where the surface leans by `lean_rad` to the section's normal direction (A22): the ball
/// touches above or below the plane, and the section comes out too thick. Leans above 84 degrees count as that.
struct LeanError {
    double in_plane_mm = 0.0;  ///< r (1/cos a - 1), seed 000, eq 18
    double normal_mm = 0.0;    ///< r (1 - cos a), to the surface
    double height_mm = 0.0;    ///< r sin a, of the true contact
};
LeanError lean_error(double ball_radius_mm, double lean_rad);

}  // namespace cmm::fitting
