// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"

namespace cmm::acquisition {

/// Triangles over shared vertices, millimetres. A value.
struct TriangleMesh {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// PLY (ascii, binary of either byte order) and STL (ascii, binary; equal vertices are joined), told apart by content.
/// Errors: input_missing, input_invalid.
core::Result<TriangleMesh> read_mesh(const std::string& path);
core::Result<TriangleMesh> read_ply(std::string_view content, const std::string& name);
core::Result<TriangleMesh> read_stl(std::string_view content, const std::string& name);

}  // namespace cmm::acquisition
