// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "fitting/contour_geometry.hpp"

namespace cmm::fitting {

/// The smallest circle that holds a contour, and where it touches: two opposite places, or three.
struct EnclosingCircle {
    Vec2 centre = Vec2::Zero();
    double radius = 0.0;
    std::array<ContourPlace, 3> touches;
    std::array<double, 3> shares{};  ///< by which the radius follows each of them outwards; they add up to 1
    std::size_t count = 0;
};

/// Exact: the point farthest outside enters the set that supports the circle until none is (Welzl 1991; the sets are
/// small, so they are tried), then the places are refined along the contour.
EnclosingCircle enclosing_circle(const ContourGeometry& contour);

/// The two places with the largest distance: each is the farthest from the other.
std::array<ContourPlace, 2> farthest_places(const ContourGeometry& contour);

}  // namespace cmm::fitting
