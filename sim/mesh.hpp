// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sim/bvh.hpp"
#include "sim/surface.hpp"

namespace cmm::sim {

/// What is wrong with a mesh as the boundary of a body; all zero = watertight.
struct MeshDefects {
    std::size_t boundary_edges = 0;  ///< edges of one triangle only: holes
    std::size_t crowded_edges = 0;   ///< edges of more than two triangles
    std::size_t twisted_edges = 0;   ///< neighbours that disagree about outside
    bool watertight() const { return boundary_edges + crowded_edges + twisted_edges == 0; }
};

/// The exact signed distance to a triangle mesh: nearest point over all triangles, sign by the angle-weighted pseudo
/// normal of the face, edge or corner it lies on (Baerentzen and Aanaes 2005). A mesh whose volume is negative is
/// turned inside out. With holes the sign is that of the nearest normal. Millimetres; immutable; may be asked from
/// several threads.
class MeshSurface final : public Surface {
  public:
    /// At least one triangle, indices in range (the readers of mesh_file.hpp see to it).
    explicit MeshSurface(TriangleMesh mesh);

    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override;
    Box box() const override { return box_; }

    /// The same with the place on the mesh, for surfaces that refine it.
    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm, Bvh::Hit& hit) const;

    const TriangleMesh& mesh() const { return mesh_; }
    const MeshDefects& defects() const { return defects_; }

  private:
    void link_edges();
    void sum_normals();
    const Eigen::Vector3d& pseudo_normal(const Bvh::Hit& hit) const;

    TriangleMesh mesh_;
    MeshDefects defects_;
    Box box_;
    std::vector<Eigen::Vector3d> face_normals_;
    std::vector<std::array<Eigen::Vector3d, 3>> edge_normals_;  // of ab, bc, ca
    std::vector<Eigen::Vector3d> vertex_normals_;
    Bvh bvh_;
};

}  // namespace cmm::sim
