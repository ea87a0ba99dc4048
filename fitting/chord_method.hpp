// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace cmm::fitting {

/// What is called the chord: the field has seven definitions, which differ by up to a per cent on a turbine blade.
enum class ChordMethod : std::uint8_t {
    nose_tail,   ///< NOSETAIL: between the points where the camber line leaves the section
    caliper,     ///< CALIPER, TANGENT: extent along the line that touches the concave side at both ends
    belac,       ///< BELAC: extent along a given direction
    x_axis,      ///< XAXIS: extent in x, the axial chord where x is axial
    rad_center,  ///< RADCENTER: between the centres of the edges' circles, and both radii
    min_circle,  ///< MINCIRCLE: diameter of the smallest circle that holds the section
    largest,     ///< MAXDIST: largest distance of two points
};
/// By keyword, in capitals or not; none: no such method.
std::optional<ChordMethod> chord_method_from(std::string_view keyword);

/// Two points of the section that tell the direction of the chord.
enum class StaggerMethod : std::uint8_t {
    nose_tail,  ///< NOSETAIL
    caliper,    ///< CALIPER: the points of the concave side that the line touches
};
std::optional<StaggerMethod> stagger_method_from(std::string_view keyword);

}  // namespace cmm::fitting
