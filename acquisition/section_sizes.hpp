// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "acquisition/evaluation.hpp"
#include "fitting/measured_section.hpp"

namespace cmm::acquisition {

/// What is always told of a section beside its profiles: le_radius, te_radius, chord, max_thickness.
void add_sizes(SectionResult& section, fitting::MeasuredSection& measured, const EvaluationOptions& options);
/// The same of a section that has no contour.
void add_sizes_not_evaluable(SectionResult& section);

}  // namespace cmm::acquisition
