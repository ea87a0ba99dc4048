// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/error.hpp"
#include "sim/surface.hpp"

/// The true contour of a part in a plane z = const, to compare measurements with.
namespace cmm::sim {

/// A closed polygon, counter-clockwise around material; the last point joins the first.
using Contour = std::vector<Eigen::Vector2d>;

/// All contours in the plane, the one of the largest area first. Of a mesh the exact cut; of smooth surfaces points
/// with |z error| < 1e-9 mm, chords within a tenth of a micrometre; of a grown surface points at the grown distance,
/// from the base's contour outwards. Errors: input_invalid when the plane misses the part or the cut is open.
core::Result<std::vector<Contour>> cut_section(const Surface& surface, double z_mm);

}  // namespace cmm::sim
