// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/surface.hpp"

namespace cmm::sim {

/// A ball that just touches.
struct BallContact {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();   ///< of the ball, its distance to the surface equals the radius
    Eigen::Vector3d foot = Eigen::Vector3d::Zero();     ///< the touched point
    Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, out of the material, foot to centre
    double s_mm = 0.0;                                  ///< centre = start + s direction
};

/// The ball's place on the line start + s direction, search_min <= s <= search_max, where it comes into contact when it
/// moves in `direction` (into the material), to 1e-8 mm. From a free start the first contact ahead, or, where there is
/// none, the nearest one behind; from a start inside the contact behind it, on the side the ball came from. A line that
/// only grazes counts as contact when it comes within 1e-7 mm. No contact within the limits: nothing. Pure but for
/// `warm`.
std::optional<BallContact> touch_along(const Surface& surface, const Eigen::Vector3d& start_mm,
                                       const Eigen::Vector3d& direction_unit, double search_min_mm,
                                       double search_max_mm, double radius_mm, std::size_t& warm);

}  // namespace cmm::sim
