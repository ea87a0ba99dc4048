// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "core/error.hpp"
#include "sim/bvh.hpp"

/// Triangle meshes from files, in millimetres. Errors: input_missing, input_invalid with file:line, or the byte where
/// the file is binary. Polygons are cut into fans; triangles that use a corner twice are left out.
namespace cmm::sim {

/// By the file's content: PLY starts with "ply", everything else is taken for STL.
core::Result<TriangleMesh> read_mesh(const std::string& path);

/// `name` stands in the messages.
core::Result<TriangleMesh> parse_ply(std::string_view content, const std::string& name);
/// Corners with the same coordinates become one.
core::Result<TriangleMesh> parse_stl(std::string_view content, const std::string& name);

}  // namespace cmm::sim
