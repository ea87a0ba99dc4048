// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "fitting/measured_section.hpp"

namespace cmm::fitting {

/// MAX_INSCRIBED: diameter of the largest circle inscribed between the sides, mm. Errors of all here: fit_not_evaluable
/// (no camber line).
core::Result<Measure> measure_max_thickness(MeasuredSection& section);

enum class PositionMethod : std::uint8_t {
    on_chord,   ///< its centre's projection on the chord NOSETAIL, as a share of the chord
    on_camber,  ///< arc length of the camber line, as a share of the whole
};
/// Where the largest inscribed circle lies, from the LE; a share. The maximum is flat: the place is known much less
/// well than the thickness.
core::Result<Measure> measure_max_thickness_position(MeasuredSection& section, PositionMethod method);

enum class EdgeName : std::uint8_t { le, te };

/// TIPARC, NORMAL: the length that both sides cut off the line across the camber line through its point at the straight
/// distance `distance_mm` from the edge's point, mm. Errors also: the camber line ends before.
core::Result<Measure> measure_edge_thickness(MeasuredSection& section, EdgeName edge, double distance_mm);

enum class AngleReference : std::uint8_t { x_axis, chord };
/// ANGOFFSET: angle from +x, or from the chord NOSETAIL, to the line through the points of the camber line at two
/// straight distances from the edge's point, in the sense LE -> TE; rad, in (-pi, pi], counter-clockwise seen from +z.
core::Result<Measure> measure_edge_angle(MeasuredSection& section, EdgeName edge, double near_mm, double far_mm,
                                         AngleReference reference);

}  // namespace cmm::fitting
