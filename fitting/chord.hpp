// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/chord_method.hpp"
#include "fitting/measured_section.hpp"

namespace cmm::fitting {

/// The chord, mm. `direction_rad`: of BELAC, from +x. Errors: fit_not_evaluable (no camber line, no concave side, an
/// edge without a radius).
core::Result<Measure> measure_chord(MeasuredSection& section, ChordMethod method, double direction_rad = 0.0);

/// The angle from +x to the direction LE -> TE, rad, in (-pi, pi], counter-clockwise seen from +z. Errors as above.
core::Result<Measure> measure_stagger(MeasuredSection& section, StaggerMethod method);

}  // namespace cmm::fitting
