// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>

namespace cmm::fitting {

/// What a nominal says of the part's walls: the outward unit normal of the nominal surface where a ball at this place
/// of the section's plane would touch it; `outward`: of the row of centres there, unit.
using NominalNormal = std::function<Eigen::Vector3d(const Eigen::Vector2d& centre, const Eigen::Vector2d& outward)>;

}  // namespace cmm::fitting
