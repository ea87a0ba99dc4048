// SPDX-License-Identifier: Apache-2.0
#include "sim/mesh_file.hpp"

#include "core/text.hpp"

namespace cmm::sim {

core::Result<TriangleMesh> read_mesh(const std::string& path) {
    auto content = core::read_file(path);
    if (!content) return tl::unexpected(content.error());
    return content->starts_with("ply") ? parse_ply(*content, path) : parse_stl(*content, path);
}

}  // namespace cmm::sim
