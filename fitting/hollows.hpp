// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A stretch of a closed curve that a ball from outside does not reach, because it rests on both ends of it first: a
/// concave corner, a step, a groove. What can be touched of a part is its closing by a disc of the ball's radius (Serra
/// 1982): the part, and in each hollow the ball.
struct Hollow {
    Vec2 centre = Vec2::Zero();  ///< of the ball at rest
    double radius_mm = 0.0;
    Vec2 begin = Vec2::Zero(), end = Vec2::Zero();  ///< where it touches, counter-clockwise along the curve
    double from = 0.0, to = 0.0;                    ///< the same as parameters; to < from: over the period's end
    double depth_mm = 0.0;                          ///< largest gap between the ball and the curve

    bool holds(double t) const { return from <= to ? t > from && t < to : t > from || t < to; }
    /// Whether the place of the closing that is nearest to a point beside it lies on the ball; `normal` is the outward
    /// one of the point's own curve, and tells this side of a thin part from the other.
    bool bridges(const Vec2& point, const Vec2& normal) const;
};

/// The hollows of a closed counter-clockwise curve, in order, without those shallower than `least_depth_mm`: exact
/// (the ball's centres are offset_curve at its radius). None for radius 0.
std::vector<Hollow> find_hollows(const PiecewiseCubic& curve, double ball_radius_mm, double least_depth_mm = 1e-3);

}  // namespace cmm::fitting
