// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sim/bvh.hpp"
#include "sim/patch.hpp"

namespace cmm::sim {

/// Parameter lines of a patch between which its facets stay within about `chord_mm` (both directions together: twice
/// that).
struct PatchLines {
    std::vector<double> u, v;
};
PatchLines choose_lines(const Patch& patch, double chord_mm);

/// The closed body over those lines. Cell (i, k) between u[i], u[i+1] and v[k], v[k+1] is made of triangles
/// 2 (k (nu - 1) + i): corners (i, k), (i+1, k), (i+1, k+1), and the next: (i, k), (i+1, k+1), (i, k+1). Then the two
/// ends.
TriangleMesh tessellate(const Patch& patch, const PatchLines& lines);

/// Triangles that fill a closed polygon (counter-clockwise in x and y) by cutting ears. Indices into `loop`.
std::vector<std::array<std::uint32_t, 3>> fill_polygon(const std::vector<Eigen::Vector2d>& loop);

}  // namespace cmm::sim
