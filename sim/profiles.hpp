// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/spline.hpp"

/// Closed profiles made ready for a loft. Millimetres, span along +z. Pure functions.
namespace cmm::sim {

inline constexpr std::size_t least_profile_points = 8;

Eigen::Vector3d mean_of(const Points& points);

/// The profiles by rising mean z, counter-clockwise seen from +z, all with the same number of points, joined by index:
/// as they are where their numbers agree, begun where they fit each other, else resampled at the arc-length fractions
/// of all their points, counted from the point of largest curvature, so that no profile loses detail. Points that
/// repeat their predecessor are left out.
std::vector<Points> joined_profiles(std::vector<Points> profiles);

}  // namespace cmm::sim
