// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Whether each point of an accused cluster continues one of its two sides: then the curve has a corner there (a ball
/// in a concave corner of the part leaves one in the curve of centres) and the points are good. `before` and `after`
/// are the nearest good points, nearest first, some four or five of each; with fewer than three on a side nothing is
/// excused.
bool continues_a_side(std::span<const Vec2> cluster, std::span<const Vec2> before, std::span<const Vec2> after,
                      double tolerance_mm);

}  // namespace cmm::fitting
