// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "core/error.hpp"
#include "fitting/contour.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// A section whose contour takes the lean of the surface into account.
struct SurfaceSection {
    SectionFit fit;
    double share = 0.0;            ///< of the curve of ball centres that was moved; elsewhere the 2-D offset stands
    double lean_doubt_mm = 0.0;    ///< there: largest error by what is not known of the lean
    double offset_error_mm = 0.0;  ///< there: largest error that the 2-D offset would have
};

/// At every break of a section's curve of ball centres: where it has to go so that the contour in its plane is the
/// plain 2-D offset of it, and what is known of the lean there.
struct SectionMovement {
    std::vector<Vec2> shift;
    std::vector<SurfaceStation> stations;
};

/// The section's curve moved and its points with it, and all that follows from fit_section's steps. In hollows that the
/// ball bridges the curve stays, and beside them the movement fades over a ball's diameter; it is smaller where the
/// lean is known less well than the 2-D offset errs, and none from twice that on. `smooth`: the curve that the movement
/// is of, through the points of `flat`; `flat` and `options` as fit_section had them. Errors: the section's own.
core::Result<SurfaceSection> move_section(const SmoothCurve& smooth, SectionMovement movement, const SectionFit& flat,
                                          const SectionOptions& options);

}  // namespace cmm::fitting
