// SPDX-License-Identifier: Apache-2.0
#include "sim/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>
#include <utility>

namespace cmm::sim {

namespace {

double six_volumes(const TriangleMesh& mesh) {
    const Eigen::Vector3d origin = mesh.vertices[mesh.triangles.front()[0]];
    double sum = 0.0;
    for (const auto& [a, b, c] : mesh.triangles) {
        sum += (mesh.vertices[a] - origin).dot((mesh.vertices[b] - origin).cross(mesh.vertices[c] - origin));
    }
    return sum;
}

TriangleMesh outward(TriangleMesh mesh) {
    if (six_volumes(mesh) < 0.0) {
        for (auto& triangle : mesh.triangles)
            std::swap(triangle[1], triangle[2]);
    }
    return mesh;
}

double corner_angle(const Eigen::Vector3d& at, const Eigen::Vector3d& one, const Eigen::Vector3d& other) {
    const Eigen::Vector3d u = one - at, v = other - at;
    return std::atan2(u.cross(v).norm(), u.dot(v));
}

}  // namespace

MeshSurface::MeshSurface(TriangleMesh mesh) : mesh_(outward(std::move(mesh))), bvh_(mesh_) {
    box_.low = box_.high = mesh_.vertices[mesh_.triangles.front()[0]];
    for (const auto& triangle : mesh_.triangles) {
        for (const auto corner : triangle) {
            box_.low = box_.low.cwiseMin(mesh_.vertices[corner]);
            box_.high = box_.high.cwiseMax(mesh_.vertices[corner]);
        }
    }
    sum_normals();
    link_edges();
}

void MeshSurface::sum_normals() {
    face_normals_.resize(mesh_.triangles.size());
    vertex_normals_.assign(mesh_.vertices.size(), Eigen::Vector3d::Zero());
    for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
        const auto& corners = mesh_.triangles[t];
        const std::array<Eigen::Vector3d, 3> p{mesh_.vertices[corners[0]], mesh_.vertices[corners[1]],
                                               mesh_.vertices[corners[2]]};
        const Eigen::Vector3d cross = (p[1] - p[0]).cross(p[2] - p[0]);
        const double length = cross.norm();
        face_normals_[t] = length > 0.0 ? Eigen::Vector3d(cross / length) : Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < 3; ++k) {
            vertex_normals_[corners[k]] += corner_angle(p[k], p[(k + 1) % 3], p[(k + 2) % 3]) * face_normals_[t];
        }
    }
}

void MeshSurface::link_edges() {
    struct Edge {
        std::uint32_t low, high, triangle;
        std::uint8_t side;  // 0 ab, 1 bc, 2 ca
        bool rising;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
        for (std::uint8_t k = 0; k < 3; ++k) {
            const auto from = mesh_.triangles[t][k], to = mesh_.triangles[t][(k + 1U) % 3U];
            edges.push_back({std::min(from, to), std::max(from, to), t, k, from < to});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) {
        return std::tie(x.low, x.high, x.triangle, x.side) < std::tie(y.low, y.high, y.triangle, y.side);
    });
    edge_normals_.resize(mesh_.triangles.size());
    for (auto first = edges.begin(); first != edges.end();) {
        const auto last = std::find_if(first, edges.end(),
                                       [&](const Edge& e) { return e.low != first->low || e.high != first->high; });
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (auto e = first; e != last; ++e)
            sum += face_normals_[e->triangle];
        for (auto e = first; e != last; ++e)
            edge_normals_[e->triangle][e->side] = sum;
        const auto number = last - first;
        if (number == 1) ++defects_.boundary_edges;
        if (number > 2) ++defects_.crowded_edges;
        if (number == 2 && first->rising == std::next(first)->rising) ++defects_.twisted_edges;
        first = last;
    }
}

const Eigen::Vector3d& MeshSurface::pseudo_normal(const Bvh::Hit& hit) const {
    switch (hit.feature) {
        case Feature::edge_ab:
            return edge_normals_[hit.triangle][0];
        case Feature::edge_bc:
            return edge_normals_[hit.triangle][1];
        case Feature::edge_ca:
            return edge_normals_[hit.triangle][2];
        case Feature::vertex_a:
            return vertex_normals_[mesh_.triangles[hit.triangle][0]];
        case Feature::vertex_b:
            return vertex_normals_[mesh_.triangles[hit.triangle][1]];
        case Feature::vertex_c:
            return vertex_normals_[mesh_.triangles[hit.triangle][2]];
        case Feature::face:
            break;
    }
    return face_normals_[hit.triangle];
}

Contact MeshSurface::nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const {
    Bvh::Hit hit;
    return nearest(centre_mm, warm, hit);
}

Contact MeshSurface::nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm, Bvh::Hit& hit) const {
    hit = bvh_.nearest(centre_mm, warm);
    warm = hit.slot;
    const Eigen::Vector3d& outside = pseudo_normal(hit);
    const Eigen::Vector3d offset = centre_mm - hit.point;
    const double distance = std::sqrt(hit.distance_sq);
    const double sign = offset.dot(outside) < 0.0 ? -1.0 : 1.0;
    // On the surface itself the direction from foot to centre is lost in rounding; the pseudo normal takes its place.
    constexpr double on_surface_mm = 1e-9;
    const Eigen::Vector3d normal =
        distance > on_surface_mm ? Eigen::Vector3d(offset * (sign / distance)) : outside.normalized();
    return {sign * distance, hit.point, normal};
}

}  // namespace cmm::sim
