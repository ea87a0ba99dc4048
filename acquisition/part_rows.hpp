// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "acquisition/section_result.hpp"
#include "core/error.hpp"
#include "fitting/surface_rows.hpp"

/// The rows of the surface through a part's contours. Millimetres, part frame.
namespace cmm::acquisition {

/// One for each of the sections, which have contours and ascend in z: its contour. What bridges a gap there says
/// nothing of the part, and would bend the surface above and below: over a gap a row goes where the surface through
/// the sections without gaps goes, moved to meet the contour at both ends. Sections below or above all of those follow
/// one after the other. With fewer than two without a gap all keep their own bridges. Errors: fit_not_evaluable (no
/// two edges, sections that do not continue each other).
core::Result<std::vector<fitting::SurfaceRow>> part_rows(std::span<const SectionResult* const> sections);

}  // namespace cmm::acquisition
