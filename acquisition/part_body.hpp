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
    /// Through the sections without a gap, capped flat in the planes of the lowest and the highest of them.
    solid,
};

/// What a body has of its part.
struct WrittenBody {
    std::vector<const SectionResult*> passed_over;  ///< sections that it has nothing of
    double off_rms_mm = 0.0, off_max_mm = 0.0;      ///< how far what was measured of the contours is from its surface
    const SectionResult* farthest = nullptr;        ///< the section where that is most
};

/// A STEP file (AP242) with the B-spline surface itself. Errors: fit_not_evaluable (fewer than 2 such sections, some
/// that do not continue each other, a surface of nothing but holes, a body that Open CASCADE's checker does not call
/// valid), journal_io, config_invalid (built without Open CASCADE).
core::Result<WrittenBody> export_step(const PartResult& part, PartBody body, const std::string& file);

/// A binary STL file: triangles within 5 um of the solid. Errors: as above.
core::Result<WrittenBody> export_stl(const PartResult& part, const std::string& file);

}  // namespace cmm::acquisition
