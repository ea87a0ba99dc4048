// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

/// Plane vectors of the fitting layer: millimetres, part frame.
namespace cmm::fitting {

using Vec2 = Eigen::Vector2d;

/// z component of a x b: positive when b points to the left of a.
inline double cross(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

/// Right-hand normal (seed 000, eq 16): outward on a counter-clockwise curve. Not normalised.
inline Vec2 right_normal(const Vec2& tangent) {
    return {tangent.y(), -tangent.x()};
}

/// The vector turned by a quarter to the left.
inline Vec2 left_of(const Vec2& v) {
    return {-v.y(), v.x()};
}

/// Signed angle from a to b in (-pi, pi].
inline double turn_angle(const Vec2& a, const Vec2& b) {
    return std::atan2(cross(a, b), a.dot(b));
}

/// turn_angle of unit vectors; for small angles by the series of the arc sine, to rounding.
inline double turn_between(const Vec2& a, const Vec2& b) {
    const double s = cross(a, b), s2 = s * s;
    if (s2 > 0.01 || a.dot(b) < 0.0) return turn_angle(a, b);
    return s * (1.0 + s2 * (1.0 / 6 + s2 * (3.0 / 40 + s2 * (5.0 / 112 + s2 * (35.0 / 1152 + s2 * 63.0 / 2816)))));
}

inline bool is_finite(const Vec2& p) {
    return std::isfinite(p.x()) && std::isfinite(p.y());
}

}  // namespace cmm::fitting
