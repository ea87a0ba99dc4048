// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Where two smooth branches of a curve meet at an angle.
struct CurveCorner {
    std::size_t before = 0, after = 0;  ///< the points on either side of it, neighbours in the chain
    Vec2 position = Vec2::Zero();       ///< where the branches meet, by their parabolas
    Vec2 arriving = Vec2::Zero();       ///< unit tangents there
    Vec2 leaving = Vec2::Zero();
    double turn_rad = 0.0;        ///< to the right
    double turn_sigma_rad = 0.0;  ///< standard deviation
};

/// The corners of a closed counter-clockwise chain of ball centres, in order. A ball in a concave corner of the part,
/// or in a hollow sharper than itself, touches both flanks at once, and the curve of its centres turns right there at
/// once; to the left it cannot (an outer parallel curve is round there).
///
/// At a gap between two neighbours that turns right by more than its surroundings do, either side is fitted by a
/// parabola over 5 to 12 points, some two of which may be bad. The gap holds a corner when both parabolas agree with
/// `sigma_mm` (standard deviation of a point), meet within the gap, turn there by more than six standard deviations of
/// that angle, and explain the points better than one quintic through all of them does, which has as many
/// coefficients. Points at most one of which lies on a fillet are not told from a corner. O(n).
std::vector<CurveCorner> find_corners(std::span<const Vec2> points, double sigma_mm);

}  // namespace cmm::fitting
