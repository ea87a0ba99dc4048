// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"
#include "fitting/measured_section.hpp"

namespace cmm::fitting {

/// Smallest distance between a section and its neighbour in a cascade, which is taken to be the same section moved by
/// `pitch_mm`: of one measured blade there is a throat to the nominal pitch only. mm. Errors: fit_not_evaluable (the
/// neighbours touch or cross).
core::Result<Measure> measure_throat(MeasuredSection& section, const Vec2& pitch_mm);

}  // namespace cmm::fitting
