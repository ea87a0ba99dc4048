// SPDX-License-Identifier: Apache-2.0
#include "sim/section_cut.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/text.hpp"
#include "sim/contact.hpp"
#include "sim/mesh.hpp"
#include "sim/offset.hpp"
#include "sim/patch.hpp"

namespace cmm::sim {

using core::ErrorCode;
using core::fail;
using core::Result;

namespace {

double area(const Contour& loop) {
    double twice = 0.0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Eigen::Vector2d a = loop[i] - loop[0], b = loop[(i + 1) % loop.size()] - loop[0];
        twice += a.x() * b.y() - b.x() * a.y();
    }
    return 0.5 * twice;
}

tl::unexpected<core::Error> at_height(double z, const std::string& what) {
    return fail(ErrorCode::input_invalid, "section at z = " + core::fixed(z, 3) + " mm: " + what);
}

using EdgeKey = std::pair<std::uint32_t, std::uint32_t>;

/// Where an edge crosses the plane; computed from the lower corner index up, so that both its triangles get the same
/// point.
Eigen::Vector2d crossing(const TriangleMesh& mesh, EdgeKey edge, double z) {
    const auto &a = mesh.vertices[edge.first], &b = mesh.vertices[edge.second];
    return a.head<2>() + (z - a.z()) / (b.z() - a.z()) * (b - a).head<2>();
}

/// Corners in the plane count as above it. Each crossed triangle is left by its rising edge and entered by its falling
/// one, which walks counter-clockwise around the material.
Result<std::vector<Contour>> cut_mesh(const TriangleMesh& mesh, double z) {
    std::map<EdgeKey, EdgeKey> next;
    for (const auto& corners : mesh.triangles) {
        std::optional<EdgeKey> rising, falling;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto from = corners[k], to = corners[(k + 1) % 3];
            const bool from_above = mesh.vertices[from].z() >= z, to_above = mesh.vertices[to].z() >= z;
            if (from_above == to_above) continue;
            (to_above ? rising : falling) = EdgeKey{std::min(from, to), std::max(from, to)};
        }
        if (rising && falling) next[*falling] = *rising;
    }
    std::vector<Contour> loops;
    while (!next.empty()) {
        Contour loop;
        const EdgeKey first = next.begin()->first;
        EdgeKey edge = first;
        do {
            const auto step = next.find(edge);
            if (step == next.end()) return at_height(z, "the mesh has a hole there, its cut is open");
            const Eigen::Vector2d p = crossing(mesh, edge, z);
            if (loop.empty() || p != loop.back()) loop.push_back(p);
            edge = step->second;
            next.erase(step);
        } while (edge != first);
        if (loop.size() > 1 && loop.front() == loop.back()) loop.pop_back();
        if (loop.size() > 2) loops.push_back(std::move(loop));
    }
    return loops;
}

/// v at which the line u = const of the patch crosses the plane: Newton, kept between the ends.
std::optional<double> height_parameter(const Patch& patch, double u, double z, double start) {
    double low = patch.v_breaks().front(), high = patch.v_breaks().back();
    if (patch.point(u, low).z() > z || patch.point(u, high).z() < z) return std::nullopt;
    double v = start;
    for (int i = 0; i < 100; ++i) {
        const PatchPoint p = patch.at(u, v);
        const double miss = p.s.z() - z;
        if (std::abs(miss) < 1e-11) break;
        (miss > 0.0 ? high : low) = v;
        v = p.sv.z() > 0.0 ? v - miss / p.sv.z() : low;
        if (!(v > low && v < high)) v = 0.5 * (low + high);
    }
    return v;
}

Result<std::vector<Contour>> cut_patch(const PatchSurface& surface, double z) {
    constexpr int parts = 8;  // of the tessellation's lines: their chord error falls by 64
    const auto& lines = surface.u_lines();
    const Patch& patch = surface.patch();
    Contour loop;
    double v = 0.5 * (patch.v_breaks().front() + patch.v_breaks().back());
    for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
        for (int k = 0; k < parts; ++k) {
            const double u = std::lerp(lines[i], lines[i + 1], static_cast<double>(k) / parts);
            const auto crossed = height_parameter(patch, u, z, v);
            if (!crossed) return at_height(z, "outside the part");
            v = *crossed;
            loop.emplace_back(patch.point(u, v).head<2>());
        }
    }
    return std::vector<Contour>{std::move(loop)};
}

/// Moves the base's contour out in the plane until the base's distance is the offset.
Result<std::vector<Contour>> cut_offset(const OffsetSurface& surface, double z) {
    auto loops = cut_section(surface.base(), z);
    if (!loops) return loops;
    constexpr double spacing_mm = 0.05;
    const double offset = surface.offset_mm(), reach = 20.0 * std::abs(offset) + 0.1;
    std::size_t warm = 0;
    for (auto& loop : *loops) {
        Contour grown;
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Eigen::Vector2d from = loop[i], to = loop[(i + 1) % loop.size()];
            const int parts = 1 + static_cast<int>((to - from).norm() / spacing_mm);
            for (int k = 0; k < parts; ++k) {
                const Eigen::Vector2d p = from + (to - from) * (static_cast<double>(k) / parts);
                const Eigen::Vector3d on(p.x(), p.y(), z);
                const Eigen::Vector3d normal = surface.base().nearest(on, warm).normal;
                const Eigen::Vector3d out = Eigen::Vector3d(normal.x(), normal.y(), 0.0).normalized();
                const auto ball = touch_along(surface.base(), on + offset * out, -out, -reach, reach, offset, warm);
                if (ball) grown.emplace_back(ball->centre.head<2>());
            }
        }
        loop = std::move(grown);
    }
    return loops;
}

}  // namespace

Result<std::vector<Contour>> cut_section(const Surface& surface, double z_mm) {
    Result<std::vector<Contour>> loops = at_height(z_mm, "this kind of surface cannot be cut");
    if (const auto* mesh = dynamic_cast<const MeshSurface*>(&surface)) loops = cut_mesh(mesh->mesh(), z_mm);
    if (const auto* patch = dynamic_cast<const PatchSurface*>(&surface)) loops = cut_patch(*patch, z_mm);
    if (const auto* offset = dynamic_cast<const OffsetSurface*>(&surface)) loops = cut_offset(*offset, z_mm);
    if (!loops) return loops;
    if (loops->empty()) return at_height(z_mm, "outside the part");
    std::stable_sort(loops->begin(), loops->end(),
                     [](const Contour& a, const Contour& b) { return std::abs(area(a)) > std::abs(area(b)); });
    return loops;
}

}  // namespace cmm::sim
