// SPDX-License-Identifier: Apache-2.0
#include "sim/geometry_source.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/units.hpp"
#include "sim/loft.hpp"
#include "sim/mesh.hpp"
#include "sim/mesh_file.hpp"
#include "sim/section_file.hpp"

namespace cmm::sim {

using core::Result;

namespace {

Warp warp_for(const Deviation& deviation, const Box& box) {
    Warp warp;
    warp.twist_rad = deviation.twist_rad;
    warp.shift_mm = deviation.shift_mm;
    warp.centre_mm = 0.5 * (box.low + box.high).head<2>();
    warp.z_low_mm = box.low.z();
    warp.z_high_mm = box.high.z() > box.low.z() ? box.high.z() : box.low.z() + 1.0;
    return warp;
}

Box box_of(const std::vector<Eigen::Vector3d>& points) {
    Box box{points.front(), points.front()};
    for (const auto& p : points) {
        box.low = box.low.cwiseMin(p);
        box.high = box.high.cwiseMax(p);
    }
    return box;
}

Result<std::shared_ptr<const Surface>> build_mesh(const GeometrySource& source, const Deviation& deviation,
                                                  std::vector<std::string>& remarks) {
    auto mesh = read_mesh(source.files.front());
    if (!mesh) return tl::unexpected(mesh.error());
    const Warp warp = warp_for(deviation, box_of(mesh->vertices));
    for (auto& vertex : mesh->vertices)
        vertex = warp(vertex);
    auto surface = std::make_shared<MeshSurface>(*std::move(mesh));
    const auto& defects = surface->defects();
    if (!defects.watertight()) {
        remarks.push_back(
            source.files.front() + ": the mesh is not watertight (" + std::to_string(defects.boundary_edges) +
            " boundary edges, " + std::to_string(defects.crowded_edges) + " edges of more than two triangles, " +
            std::to_string(defects.twisted_edges) +
            " between triangles that disagree about outside); near them inside and outside may be confused");
    }
    return surface;
}

Result<std::shared_ptr<const Surface>> build_blade(const GeometrySource& source, const Deviation& deviation) {
    const auto in_context = [&](core::Error error) {
        error.message = source.where + ": blade: " + error.message;
        return tl::unexpected(std::move(error));
    };
    auto plain = BladePatch::make(source.blade, 0.0);
    if (!plain) return in_context(plain.error());
    auto patch = BladePatch::make(source.blade, source.beyond_mm, warp_for(deviation, PatchSurface(*plain).box()));
    if (!patch) return in_context(patch.error());
    return std::make_shared<PatchSurface>(*patch);
}

/// The files of a name whose last part holds * or ?, in alphabetic order; a plain name is its own list.
Result<std::vector<std::string>> matching_files(const std::string& name) {
    const std::filesystem::path path(name);
    const std::string pattern = path.filename().string();
    if (pattern.find_first_of("*?") == std::string::npos) return std::vector<std::string>{name};
    std::vector<std::string> found;
    std::error_code failed;
    for (const auto& entry :
         std::filesystem::directory_iterator(path.has_parent_path() ? path.parent_path() : ".", failed)) {
        if (::fnmatch(pattern.c_str(), entry.path().filename().c_str(), FNM_PERIOD) == 0)
            found.push_back(entry.path().string());
    }
    if (found.empty()) return core::fail(core::ErrorCode::input_missing, name + ": no file of that name");
    std::sort(found.begin(), found.end());
    return found;
}

Result<std::shared_ptr<const Surface>> build_loft(const GeometrySource& source, const Deviation& deviation) {
    std::vector<std::string> files;
    for (const auto& name : source.files) {
        const auto some = matching_files(name);
        if (!some) return tl::unexpected(some.error());
        files.insert(files.end(), some->begin(), some->end());
    }
    auto profiles = read_sections(files, source.span);
    if (!profiles) return tl::unexpected(profiles.error());
    Points all;
    for (const auto& profile : *profiles)
        all.insert(all.end(), profile.begin(), profile.end());
    const Warp warp = warp_for(deviation, box_of(all));
    for (auto& profile : *profiles) {
        for (auto& point : profile)
            point = warp(point);
    }
    auto patch = LoftPatch::make(*std::move(profiles), source.beyond_mm);
    if (!patch) {
        patch.error().message = source.where + ": " + patch.error().message;
        return tl::unexpected(patch.error());
    }
    return std::make_shared<PatchSurface>(*patch);
}

}  // namespace

BladeNumbers read_blade(const core::ConfigTable& table) {
    const core::Bounds lengths{1e-3, 1e5};
    const auto angle = [&](std::string_view key, double most_deg) {
        return core::rad_from_deg(table.number(key, 0.0, {-most_deg, most_deg}));
    };
    BladeNumbers n;
    n.chord_root_mm = table.required_number("chord_root_mm", lengths);
    n.chord_tip_mm = table.number("chord_tip_mm", n.chord_root_mm, lengths);
    n.thickness_root_mm = table.required_number("thickness_root_mm", lengths);
    n.thickness_tip_mm = table.number("thickness_tip_mm", n.thickness_root_mm, lengths);
    n.camber_rad = angle("camber_deg", 170.0);
    n.stagger_root_rad = angle("stagger_root_deg", 360.0);
    n.stagger_tip_rad = table.has("stagger_tip_deg") ? angle("stagger_tip_deg", 360.0) : n.stagger_root_rad;
    n.le_radius_mm = table.required_number("le_radius_mm", lengths);
    n.te_radius_mm = table.required_number("te_radius_mm", lengths);
    n.lean_x_rad = angle("lean_x_deg", 60.0);
    n.lean_y_rad = angle("lean_y_deg", 60.0);
    n.z_root_mm = table.number("z_root_mm", 0.0);
    n.z_tip_mm = table.required_number("z_tip_mm");
    return n;
}

Result<std::shared_ptr<const Surface>> build_surface(const GeometrySource& source, const Deviation& deviation,
                                                     std::vector<std::string>& remarks) {
    switch (source.kind) {
        case GeometrySource::Kind::parametric:
            return build_blade(source, deviation);
        case GeometrySource::Kind::mesh:
            return build_mesh(source, deviation, remarks);
        case GeometrySource::Kind::sections:
            break;
    }
    return build_loft(source, deviation);
}

}  // namespace cmm::sim
