// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/smoothing_system.hpp"
#include "fitting/told_edge.hpp"

namespace cmm::fitting {

/// `smooth_closed`, kept for when something else than the points tells where its joints are.
class ClosedSmoothing {
  public:
    core::Result<SmoothCurve> run(std::span<const Vec2> points, std::span<const GapBridge> bridges = {});
    /// The curve of the latest `run` where edges are told: joints that it shows there are where they are told, and
    /// others come to them; each has to be borne out by the points all the same. Between the two of an edge the
    /// curvature is expected to change as it is told. Errors: fit_not_evaluable (singular).
    core::Result<SmoothCurve> with(std::span<const ToldEdge> told) const;

  private:
    std::vector<Vec2> points_;               // by their first parameters, from the origin
    std::vector<double> supposed_sigma_mm_;  // 0: measured; empty: all are
    std::vector<std::size_t> order_;         // their numbers
    Vec2 origin_ = Vec2::Zero();
    SmoothingSystem::State plain_;  // without joints
};

}  // namespace cmm::fitting
