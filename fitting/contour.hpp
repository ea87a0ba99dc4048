// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// From the fitted curve of ball centres to the part: edge arcs, joins, offset, zones, sampling, chord and thickness;
/// fills these fields of `fit`, whose noise is known already. `good` are the points that `smooth` was fitted to.
/// Errors: fit_not_evaluable (no two edges, ball too large).
core::Status build_contour(const SmoothCurve& smooth, std::span<const Vec2> good, const SectionOptions& options,
                           SectionFit& fit);

}  // namespace cmm::fitting
