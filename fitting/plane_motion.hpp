// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A rigid motion of the plane: turned by `turn_rad` about `about_mm`, counter-clockwise, then moved by `shift_mm`.
struct PlaneMotion {
    Vec2 about_mm = Vec2::Zero(), shift_mm = Vec2::Zero();
    double turn_rad = 0.0;

    static Vec2 turned(const Vec2& v, double angle_rad) {
        const double c = std::cos(angle_rad), s = std::sin(angle_rad);
        return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
    }
    Vec2 apply(const Vec2& p) const { return turned(p - about_mm, turn_rad) + about_mm + shift_mm; }
    Vec2 apply_to_direction(const Vec2& v) const { return turned(v, turn_rad); }
    Vec2 undo(const Vec2& p) const { return turned(p - about_mm - shift_mm, -turn_rad) + about_mm; }
    Vec2 undo_on_direction(const Vec2& v) const { return turned(v, -turn_rad); }
};

}  // namespace cmm::fitting
