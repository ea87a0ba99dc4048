// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/surface.hpp"

namespace cmm::fitting {

/// A point of the surface S + d N at a height, N the unit normal of S; it is the normal of S + d N as well.
struct CutPoint {
    SurfacePlace place;
    Vec3 position = Vec3::Zero();
    Vec3 normal = Vec3::Zero();
    bool folded = false;  ///< S + d N runs backwards here (|d| above a radius of curvature): a ball does not touch
};

/// The cut of S + d N with the plane z = const, in the order of u.
struct PlaneCut {
    std::vector<CutPoint> points;
    std::size_t folded = 0;  ///< so many of them
};

/// Cuts S + d N, whose height grows with v along every curve u = const: at each asked u, v by Newton's method on
/// z(u, v) = z_mm, held in a bracket; exact to 1e-12 of the height. d = 0: the surface itself; d = -r: from the ball
/// centres to the part (seed 000, A6). Errors: fit_not_evaluable (the plane misses the surface somewhere, its height
/// does not grow with v).
core::Result<PlaneCut> cut_at_height(const Surface& surface, double distance_mm, double z_mm,
                                     std::span<const double> u);

/// Every span of the u-axis, cut into `parts` equal steps.
std::vector<double> span_parameters(const CubicAxis& axis, std::size_t parts);

}  // namespace cmm::fitting
