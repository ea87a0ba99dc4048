// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "sim/triangle.hpp"

namespace cmm::sim {

/// Corners (by index, counter-clockwise seen from outside) of a surface made of triangles. Millimetres.
struct TriangleMesh {
    std::vector<Eigen::Vector3d> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// The nearest triangle to a point, exactly: a tree of axis-parallel boxes (surface-area heuristic), walked nearest box
/// first and cut by the best distance so far. Immutable; may be asked from several threads.
class Bvh {
  public:
    struct Hit {
        std::size_t slot = 0;      ///< place in the tree's order: pass it as `start` for the next point nearby
        std::size_t triangle = 0;  ///< index in the mesh
        Eigen::Vector3d point = Eigen::Vector3d::Zero();
        Feature feature = Feature::face;
        double distance_sq = 0.0;
    };

    /// The mesh has at least one triangle; it may go afterwards.
    explicit Bvh(const TriangleMesh& mesh);
    /// `start`: the slot of an earlier hit; any value is safe, a good one is fast.
    Hit nearest(const Eigen::Vector3d& p, std::size_t start) const;

  private:
    struct Node {
        std::array<std::array<double, 6>, 2> box;  // low x y z, high x y z of each child
        std::array<std::uint32_t, 2> child;        // inner: node index; leaf: first slot
        std::array<std::uint32_t, 2> count;        // leaf: triangles; inner: 0
    };
    struct Builder;
    void scan_leaf(const Eigen::Vector3d& p, std::uint32_t first, std::uint32_t count, Hit& best) const;

    std::vector<Node> nodes_;
    std::vector<TriangleEdges> slots_;
    std::vector<std::uint32_t> order_;
};

}  // namespace cmm::sim
