// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// Where the nominal is a surface: the signed distance of each contour point to it along its normal, positive where
/// there is too much material, after the section's alignment; none where the ball does not reach the nominal, and where
/// the surface ends. Where it leans by a this is cos(a) of the deviation in the plane, but for second order. Empty: the
/// nominal is no surface, or nothing was compared. For pictures: some milliseconds a section, not on the way to a
/// decision.
std::vector<std::optional<double>> surface_deviations(const SectionResult& section);

}  // namespace cmm::acquisition
