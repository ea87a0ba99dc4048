// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "sim/surface.hpp"

namespace cmm::sim {

/// The way along the straight line from `from` to `to` at which a ball first touches the part (its centre at one radius
/// from the surface, to 1 nm), or nothing. A ball that already touches may leave: only going deeper counts. Pure.
std::optional<double> first_contact(const Surface& surface, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                                    double radius_mm);

}  // namespace cmm::sim
