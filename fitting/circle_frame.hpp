// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Coordinates along (u) and across (y, positive to the right) the circle through three points, so that an edge of any
/// radius is nearly straight.
class CircleFrame {
  public:
    CircleFrame(const Vec2& a, const Vec2& b, const Vec2& c) : origin_(b) {
        const Vec2 ab = b - a, bc = c - b;
        const double lab = ab.norm(), product = lab * bc.norm() * (c - a).norm();
        curvature_ = product > 0.0 ? 2.0 * cross(ab, bc) / product : 0.0;
        const double sine = std::clamp(0.5 * curvature_ * lab, -0.9, 0.9), cosine = std::sqrt(1.0 - sine * sine);
        const Vec2 unit = lab > 0.0 ? Vec2(ab / lab) : Vec2(Vec2::UnitX());
        along_ = cosine * unit - sine * right_normal(unit);
    }

    /// u = 2 R tan(angle/2), y = distance from the circle; written so that R = 1/curvature may be infinite. A place
    /// beyond the circle's middle, but not by half the radius, lies that far from the near side, not the far one.
    Vec2 local(const Vec2& p) const {
        const Vec2 d = p - origin_;
        const double x = d.dot(along_), left = cross(along_, d), k = curvature_;
        const double c = 1.0 - k * left, away = std::sqrt(k * k * x * x + c * c);
        const double r = c < 0.0 && away < just_beyond ? -away : away, reach = c + r;
        return {2.0 * x / (std::abs(reach) < least_reach ? least_reach : reach),
                (k * (x * x + left * left) - 2.0 * left) / (1.0 + r)};
    }
    /// The same of many points, in their place: their x becomes u, their y becomes y.
    template <class Numbers>
    void bring(Numbers& xs, Numbers& ys) const {
        const Numbers dx = xs - origin_.x(), dy = ys - origin_.y();
        const Numbers x = dx * along_.x() + dy * along_.y(), left = along_.x() * dy - along_.y() * dx;
        const double k = curvature_;
        const Numbers c = 1.0 - k * left, away = (k * k * x * x + c * c).sqrt();
        const Numbers r = (c < 0.0 && away < just_beyond).select(-away, away), reach = c + r;
        xs = 2.0 * x / (reach.abs() < least_reach).select(least_reach, reach);
        ys = (k * (x * x + left * left) - 2.0 * left) / (1.0 + r);
    }
    /// Whether a place is so far round the circle that the coordinates say little: 62 degrees from the middle.
    bool is_far(double u) const { return std::abs(u * curvature_) > 2.0 * widest_half_angle; }
    double curvature() const { return curvature_; }

  private:
    static constexpr double widest_half_angle = 0.6;  // tan(theta/2)
    static constexpr double just_beyond = 0.5;        // of the radius, from the middle
    static constexpr double least_reach = 1e-9;

    Vec2 origin_, along_;
    double curvature_ = 0.0;
};

}  // namespace cmm::fitting
