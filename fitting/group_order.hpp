// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cmm::fitting {

/// An order of places in which those that are near each other come into one group of `size`, groups that are near each
/// other into one of `size` groups, and so on: halved across the longest extent, always where such a group ends. Finite
/// places, fewer than 2^32; size 2 or more.
std::vector<std::uint32_t> order_in_groups(std::span<const Eigen::Vector3d> places, std::size_t size);

}  // namespace cmm::fitting
