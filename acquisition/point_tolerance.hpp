// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "acquisition/profile.hpp"

namespace cmm::acquisition {

/// What it is called in the results.
inline constexpr const char* point_tolerance_name = "point_tolerance";

/// The tolerances of the nominal at each point of the section's contour, as it lies after the alignment.
std::vector<PointTolerance> tolerances_along(const SectionResult& section, const ReferenceContour& nominal);

/// How far the contour lies beyond the tolerances that the nominal has at its points, at the worst place: above 0 it is
/// out, below 0 that much is left. Every place counts against its own two limits; filters and guard as of the
/// profiles. `section` has tolerances. Not evaluable where no place has a deviation.
Characteristic point_tolerance(const SectionResult& section, const Compared& compared,
                               const EvaluationOptions& options);
Characteristic point_tolerance_not_evaluable(const EvaluationOptions& options, const std::string& why);

}  // namespace cmm::acquisition
