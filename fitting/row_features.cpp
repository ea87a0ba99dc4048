// SPDX-License-Identifier: Apache-2.0
#include "fitting/row_features.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double joint_reach = 2.0;  // from an edge's end, of the end's distance from the nose

}  // namespace

void RowFeatures::set_joints(std::span<const RowJoint> found) {
    joints = {};
    const auto distance = [&](double a, double b) {
        const double d = std::abs(a - b);
        return std::min(d, length_mm - d);
    };
    for (const RowJoint& joint : found) {
        if (!std::isfinite(joint.s_mm) || !std::isfinite(joint.sigma_mm) || !std::isfinite(joint.step)) continue;
        std::optional<std::size_t> nearest;
        for (const std::size_t j : {le_end, te_begin, te_end, le_begin})
            if (!nearest || distance(s_mm[j], joint.s_mm) < distance(s_mm[*nearest], joint.s_mm)) nearest = j;
        const std::size_t nose = *nearest == te_begin || *nearest == te_end ? te_nose : le_nose;
        const double reach = joint_reach * distance(s_mm[*nearest], s_mm[nose]);
        auto& known = joints[*nearest];
        if (distance(s_mm[*nearest], joint.s_mm) > reach || (known && std::abs(joint.step) < std::abs(known->step)))
            continue;
        known = joint;
    }
}

}  // namespace cmm::fitting
