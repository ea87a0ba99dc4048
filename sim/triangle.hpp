// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

namespace cmm::sim {

/// Where on a triangle a nearest point lies: decides which normal gives the sign of the distance.
enum class Feature : std::uint8_t { face, edge_ab, edge_bc, edge_ca, vertex_a, vertex_b, vertex_c };

struct TriangleFoot {
    Eigen::Vector3d point;
    Feature feature;
};

/// A triangle prepared for many queries: one corner and the two edges from it.
struct TriangleEdges {
    Eigen::Vector3d a, ab, ac;
};

/// The point of a triangle nearest to p, by the regions of its corners, edges and face (Ericson, Real-Time Collision
/// Detection 2005, 5.1.5). A triangle without area answers with a point of its edges.
inline TriangleFoot closest_on_triangle(const Eigen::Vector3d& p, const TriangleEdges& t) {
    const Eigen::Vector3d ap = p - t.a;
    const double d1 = t.ab.dot(ap), d2 = t.ac.dot(ap);
    if (d1 <= 0.0 && d2 <= 0.0) return {t.a, Feature::vertex_a};
    const double bb = t.ab.squaredNorm(), cc = t.ac.squaredNorm(), bc = t.ab.dot(t.ac);
    const double d3 = d1 - bb, d4 = d2 - bc;  // the same products from b ...
    if (d3 >= 0.0 && d4 <= d3) return {t.a + t.ab, Feature::vertex_b};
    const double d5 = d1 - bc, d6 = d2 - cc;  // ... and from c
    if (d6 >= 0.0 && d5 <= d6) return {t.a + t.ac, Feature::vertex_c};
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return {t.a + d1 / (d1 - d3) * t.ab, Feature::edge_ab};
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return {t.a + d2 / (d2 - d6) * t.ac, Feature::edge_ca};
    const double va = d3 * d6 - d5 * d4;
    const double sum = va + vb + vc;
    if ((va <= 0.0 && d4 >= d3 && d5 >= d6) || sum <= 0.0) {
        const double w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return {t.a + t.ab + w * (t.ac - t.ab), Feature::edge_bc};
    }
    return {t.a + (vb / sum) * t.ab + (vc / sum) * t.ac, Feature::face};
}

}  // namespace cmm::sim
