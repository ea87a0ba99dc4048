// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/compensation.hpp"
#include "fitting/section.hpp"

namespace cmm::fitting {

/// A point of a section that lies off what all other sections foretell.
struct StrayPoint {
    std::size_t index = 0;  ///< among the section's points
    double off_mm = 0.0;    ///< signed, outwards
};

/// Bad points that nothing in their own section betrays (two or three beside an edge, where the next good one is far):
/// where the section at `z_mm` strays from the surface of ball centres through all sections, those of its `centres`
/// that lie farther off it than the others' scatter and three tenths of the farthest allow. Runs of more than five are
/// a feature of the part, and none of it is taken; points that are out already (`verdicts`: no contact, operator,
/// duplicate) or that an operator keeps are passed over. `surface` has been laid; one per input point.
std::vector<StrayPoint> stray_points(const SurfaceCompensation& surface, double z_mm, std::span<const Vec2> centres,
                                     std::span<const PointVerdict> verdicts);

}  // namespace cmm::fitting
