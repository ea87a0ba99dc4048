// SPDX-License-Identifier: Apache-2.0
#include "acquisition/triangle_mesh.hpp"

#include "core/text.hpp"

namespace cmm::acquisition {

core::Result<TriangleMesh> read_mesh(const std::string& path) {
    const auto content = core::read_file(path);
    if (!content) return tl::unexpected(content.error());
    auto mesh = content->starts_with("ply") ? read_ply(*content, path) : read_stl(*content, path);
    if (!mesh) return mesh;
    for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
        if (mesh->vertices[i].allFinite()) continue;
        return core::fail(core::ErrorCode::input_invalid, path + ": vertex " + std::to_string(i) + " is not finite");
    }
    for (std::size_t i = 0; i < mesh->triangles.size(); ++i) {
        for (const auto v : mesh->triangles[i]) {
            if (v < mesh->vertices.size()) continue;
            return core::fail(core::ErrorCode::input_invalid, path + ": face " + std::to_string(i) + " names vertex " +
                                                                  std::to_string(v) + " of " +
                                                                  std::to_string(mesh->vertices.size()));
        }
    }
    if (mesh->triangles.empty()) return core::fail(core::ErrorCode::input_invalid, path + ": the mesh has no faces");
    return mesh;
}

}  // namespace cmm::acquisition
