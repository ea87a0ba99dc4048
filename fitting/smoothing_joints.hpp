// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/smoothing_system.hpp"
#include "fitting/told_edge.hpp"

namespace cmm::fitting {

/// Finishes a smoothed curve whose curvature is continuous, the `plain` one: where its curvature has ramps that stand
/// for jumps, it gets knots between which it may jump, each placed where the tangents of both sides agree. A joint that
/// the points do not bear out is given up, and the others are placed again from the curve as it came (docs/theory.md,
/// section 3). The system is measured in the end. The joints of `told` edges are where they are told. Returns the
/// joints in order. Errors: fit_not_evaluable (singular without joints).
core::Result<std::vector<CurvatureStep>> place_joints(SmoothingSystem& system, const SmoothingSystem::State& plain,
                                                      std::span<const ToldEdge> told);

}  // namespace cmm::fitting
