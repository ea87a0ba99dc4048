// SPDX-License-Identifier: Apache-2.0
// Files of points and meshes that users bring: PLY, STL, CRV, point lists. The first byte chooses.
#include <cstdlib>

#include "acquisition/crv_file.hpp"
#include "acquisition/points_file.hpp"
#include "acquisition/triangle_mesh.hpp"
#include "fuzz/work_file.hpp"

namespace {

using namespace cmm::acquisition;

/// Whatever was read is finite, and no triangle names a corner that is not there.
void check(const cmm::core::Result<TriangleMesh>& mesh) {
    if (!mesh) return;
    for (const auto& vertex : mesh->vertices)
        if (!vertex.allFinite()) std::abort();
    for (const auto& triangle : mesh->triangles)
        for (const auto corner : triangle)
            if (corner >= mesh->vertices.size()) std::abort();
}

void check(const cmm::core::Result<std::vector<PointSection>>& sections) {
    if (!sections) return;
    for (const PointSection& section : *sections)
        for (const auto& point : section.points_mm)
            if (!point.allFinite()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0) return 0;
    static const WorkFile work(".csv");
    const std::span<const std::uint8_t> content(data + 1, size - 1);
    const std::string text(content.begin(), content.end());
    switch (data[0] % 4) {
        case 0:
            check(read_mesh(work.holds(content)));
            break;
        case 1:
            static_cast<void>(read_stl(text, "part.stl"));
            break;
        case 2:
            check(read_crv(text, "part.crv"));
            break;
        default:
            check(read_points(work.holds(content)));
    }
    return 0;
}
