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
    const auto nose_of = [](std::size_t end) { return end == te_begin || end == te_end ? te_nose : le_nose; };
    const auto is_on_side_of = [&](std::size_t end, double s) {
        const bool ahead = std::remainder(s - s_mm[nose_of(end)], length_mm) > 0.0;
        return ahead == (end == le_end || end == te_end);
    };
    for (const RowJoint& joint : found) {
        if (!std::isfinite(joint.s_mm) || !std::isfinite(joint.sigma_mm) || !std::isfinite(joint.step)) continue;
        std::optional<std::size_t> nearest;
        for (const std::size_t j : {le_end, te_begin, te_end, le_begin})
            if (is_on_side_of(j, joint.s_mm) &&
                (!nearest || distance(s_mm[j], joint.s_mm) < distance(s_mm[*nearest], joint.s_mm)))
                nearest = j;
        if (!nearest) continue;
        const double reach = joint_reach * distance(s_mm[*nearest], s_mm[nose_of(*nearest)]);
        auto& known = joints[*nearest];
        if (distance(s_mm[*nearest], joint.s_mm) > reach || (known && std::abs(joint.step) < std::abs(known->step)))
            continue;
        known = joint;
    }
}

}  // namespace cmm::fitting
