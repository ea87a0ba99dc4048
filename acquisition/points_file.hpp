// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace cmm::acquisition {

/// The points of one section in file order. A section's name is what the file calls it, or its height.
struct PointSection {
    std::string name;
    std::vector<Eigen::Vector3d> points_mm;
    std::vector<std::uint16_t> flags;       ///< core::sample_flag bits; empty: all 0
    std::vector<std::uint64_t> sequences;   ///< of a column seq; empty: the file has none
    std::vector<std::uint8_t> passes = {};  ///< of a column pass; empty: all of the lap
    double z_mm() const;                    ///< mean height
};

/// Reads `x,y,z[,section[,flag]]` (with a header in any order, and a column seq), .xyz/.asc/.txt, .crv/.curve (chosen
/// by extension, then by content). Sections are told apart by the column, by file, by the profile comment, or by steps
/// in z (more than 20 um between runs of constant z). Errors: input_missing; input_invalid with file:line:column
/// (missing column, not a number, nan, fewer than 3 points).
core::Result<std::vector<PointSection>> read_points(const std::string& path);
core::Result<std::vector<PointSection>> read_points(std::span<const std::string> paths);

}  // namespace cmm::acquisition
