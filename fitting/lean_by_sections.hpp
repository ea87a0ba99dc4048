// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/section_mover.hpp"

namespace cmm::fitting {

/// A section as fit_section has it, with its height.
struct SectionInPlane {
    double z_mm = 0.0;
    const SectionFit* fit = nullptr;
};

/// The contour in the plane of section `own` where no surface goes round the blade (sides alone, parts of blades;
/// docs/theory.md, section 12). Each measured place is compared with up to four of the other sections, where these were
/// measured beside it: on sides along the curve's normal, at edges by the tangents of one direction. The polynomial
/// through their offsets along the normal, over z, is the surface of ball centres in the plane of the normal and z; its
/// parallel curve at the ball's radius, cut at the section's height, is the contour. The doubt in the lean is e/h as of
/// `compensate_section`. Where no two others were measured beside a place, though there are more, or they do not
/// agree on the lean, the movement goes over from that of the places on either side; its doubt is then the largest
/// error that the 2-D offset is known to have in the section. `sections` in any order, of several at one height the
/// first. Errors: fit_not_evaluable (no other section was measured beside any place, ball radius not above 0, the
/// section's own).
core::Result<SurfaceSection> compensate_by_sections(std::span<const SectionInPlane> sections, std::size_t own,
                                                    const SectionOptions& options);

}  // namespace cmm::fitting
