// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"
#include "fitting/nominal_normal.hpp"
#include "fitting/section_mover.hpp"

namespace cmm::fitting {

/// The contour in the section's plane while there is no other section: with the nominal's lean beside its curve of
/// ball centres. That the part leans as its nominal does nobody has measured: the error of the 2-D offset stands in the
/// uncertainty in full. `flat` and `options` as fit_section had them. Errors: the section's own.
core::Result<SurfaceSection> compensate_by_nominal(const SectionFit& flat, const SectionOptions& options,
                                                   const NominalNormal& nominal);

}  // namespace cmm::fitting
