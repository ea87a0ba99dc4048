// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "fitting/surface_rows.hpp"

namespace cmm::fitting {

/// Rows smoothed anew with what they have in common: joints of the curvature (an edge of the part: where most rows know
/// one, all have it, where they together say), knots at the same places of the part, and how rough it is there, which
/// single rows tell only vaguely. A row that does not follow its points so (a dent that only it has) keeps its own
/// knots and roughness; one whose points do not bear the joints stays as it is (docs/theory.md, section 11). Each round
/// fits every row with what all said in the round before; some eight settle it.
std::vector<SurfaceRow> settle_rows(std::span<const SurfaceRow> rows, int rounds);

}  // namespace cmm::fitting
