// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"
#include "fitting/compensation.hpp"
#include "fitting/nominal_normal.hpp"
#include "fitting/section.hpp"
#include "fitting/section_mover.hpp"

namespace cmm::fitting {

/// The contour in the section's plane from the surface of contacts (docs/theory.md, section 12). That surface's cut,
/// one ball radius outwards in the plane, is the curve of which the contour is the plain 2-D offset: the section's own
/// curve of ball centres is moved onto it, its points with it, and all that follows (edges, joins, loops, zones, sizes)
/// is fit_section's. Where the section's centres are off the surface by more than their noise explains, they are moved
/// by the compensation alone and keep what is theirs; where they lie apart as a rigid whole (displaced_row.hpp), by
/// that of the places that they would lie at without that motion. In hollows that the ball bridges the curve stays, and
/// beside them the movement fades over a ball's diameter; it is smaller where the lean is known less well than the 2-D
/// offset errs, and none from twice that on.
/// Uncertainty: what the surface has of the section's noise (RowScatter); added by how much the error of the 2-D offset
/// changes when the lean grows by e/h: h distance of the next section (half of it where all others lie on one side), e
/// distance of the section to the polynomial through the points of its (up to four) next sections, for an error of the
/// lean is one of the slope. With two sections nothing is known of e, and the error of the 2-D offset stands for it. A
/// section between those that the surface was made of (one with wide gaps) takes its lean from them and keeps all that
/// is its own. With a `nominal` its lean is taken instead: two sections tell it worse. Its error is how far the two are
/// apart. `flat` and `options` as fit_section had them. Errors: fit_not_evaluable (beyond the rows, the plane misses
/// the surface of contacts, the section's own).
core::Result<SurfaceSection> compensate_section(const SurfaceCompensation& surface, double z_mm, const SectionFit& flat,
                                                const SectionOptions& options, const NominalNormal& nominal = {});

}  // namespace cmm::fitting
