// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "fitting/smoothing.hpp"
#include "fitting/told_joints.hpp"

namespace cmm::fitting {

/// Where a blade's edges end by the edges as a whole: a conic through the points of an edge, and the joint where its
/// normal is that of the side as it goes on (docs/theory.md, section 3). `smooth`: the curve of ball centres through
/// `points`, which had no gaps. Of an edge that the points do not bear out as a conic up to its ends there are none. In
/// order. O(points).
std::vector<ToldJoint> joints_by_conics(const SmoothCurve& smooth, std::span<const Vec2> points, double ball_mm);

}  // namespace cmm::fitting
