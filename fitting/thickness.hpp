// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "fitting/section.hpp"

namespace cmm::fitting {

/// Diameter of the largest circle inscribed in a closed counter-clockwise contour: over its points, the largest circle
/// that touches there and holds no other contour point. O(n) with a coarse search first.
double largest_inscribed_diameter(std::span<const ContourPoint> contour);

}  // namespace cmm::fitting
