// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "fitting/smoothing.hpp"
#include "fitting/told_edge.hpp"

namespace cmm::fitting {

/// The edges of a blade by conics (arcs or ellipses) through all points of an edge, whose
/// joints are where the conic's normal is that of the side as it goes on (docs/theory.md, section 3). `smooth`: the
/// curve of ball centres through `points`, which have no gaps. An edge that the
/// points do not bear out as a conic from joint to joint is left out. `smooth` must outlive the result. O(points).
std::vector<ToldEdge> edges_by_conics(const SmoothCurve& smooth, std::span<const Vec2> points, double ball_mm);

}  // namespace cmm::fitting
