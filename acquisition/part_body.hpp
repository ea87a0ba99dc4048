// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "acquisition/section_result.hpp"
#include "core/error.hpp"

/// The measured part as one body: the surface through the contours of its sections, from the lowest to the highest of
/// them. Millimetres, part frame.
namespace cmm::acquisition {

enum class PartBody {
    /// Open at both ends, through all sections that have a contour. Where a section has a gap there is a hole, up to
    /// the sections beside it, and all round between two sections where one has no contour.
    surface,
    /// Through the sections without a gap, capped flat in the planes of the lowest and the highest of them. The file
    /// says how many sections it passes over.
    solid,
};

/// Sections of which a solid has nothing, since they have a gap or no contour.
std::vector<const SectionResult*> passed_over(const PartResult& part);

/// A STEP file (AP242) with the B-spline surface itself. Errors: fit_not_evaluable (fewer than 2 such sections, some
/// that do not continue each other, a surface of nothing but holes, a body that Open CASCADE's checker does not call
/// valid), journal_io, config_invalid (built without Open CASCADE).
core::Status export_step(const PartResult& part, PartBody body, const std::string& file);

/// A binary STL file: triangles within 5 um of the solid. Errors: as above.
core::Status export_stl(const PartResult& part, const std::string& file);

}  // namespace cmm::acquisition
