// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "fitting/closed_curve.hpp"
#include "fitting/plane_motion.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// How a section's curve of ball centres lies apart, as a rigid whole, from the curve that a surface has at its height
/// (the fixture moved, and moved back): least squares of the distances at the curve's breaks (Gauss and Newton). None
/// unless it is clear: the distances are larger than the noise of the points, and the motion explains them.
std::optional<PlaneMotion> displacement_of(const SmoothCurve& own, const ClosedCurve& level);

/// The curve without that motion.
PiecewiseCubic undone(const PiecewiseCubic& curve, const PlaneMotion& motion);

}  // namespace cmm::fitting
