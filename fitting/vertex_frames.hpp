// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <type_traits>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A conic y^2 = 2 radius depth - roundness depth^2 in the frame of its vertex, depth running inwards along the axis.
struct VertexConic {
    Vec2 vertex, axis;
    double radius, roundness;
};

/// w^2 of a conic at the angle psi of the normal to its axis, c = cos(psi): kept above zero beyond the directions that
/// a hyperbola's normals take.
template <class Number>
Number conic_support(const Number& c2, double roundness) {
    using std::max;
    using std::sqrt;
    if constexpr (std::is_same_v<Number, double>) {
        return sqrt(max(c2 + roundness * (1.0 - c2), 1e-4));
    } else {
        return (c2 + roundness * (1.0 - c2)).max(1e-4).sqrt();
    }
}

/// The feet of N points on a conic, side by side in vector lanes. By the angle psi of the normal to the axis, c its
/// cosine and s its sine, w = sqrt(c^2 + roundness s^2), the conic is depth = radius s^2/(w (w + c)), y = radius s/w,
/// and its radius of curvature radius/w^3: regular for circle, parabola and everything between. The foot's normal is
/// where p - C has no tangential part; Newton's step for psi is that part over (radius of curvature + distance). A lane
/// that has arrived stands still: its numbers do not depend on its neighbours.
template <int N>
class VertexFrames {
  public:
    using Lanes = Eigen::Array<double, N, 1>;

    /// `points` and `near` (the normals as far as they are known) hold N each.
    VertexFrames(const VertexConic& conic, const Vec2* points, const Vec2* near)
        : conic_(conic), side_(left_of(conic.axis)) {
        Lanes u, v;
        for (int k = 0; k < N; ++k) {
            u[k] = (points[k] - conic.vertex).dot(conic.axis);
            v[k] = (points[k] - conic.vertex).dot(side_);
            c_[k] = near[k].dot(conic.axis);
            s_[k] = cross(conic.axis, near[k]);
        }
        approach(u, v);
    }

    Vec2 normal(int k) const { return c_[k] * conic_.axis + s_[k] * side_; }
    Vec2 position(int k) const { return conic_.vertex - depth_[k] * conic_.axis + y_[k] * side_; }
    double slope_direction(int k) const { return -(c_[k] * y_[k] + s_[k] * depth_[k]); }
    double slope_radius(int k) const { return s_[k] * s_[k] / (w_[k] + c_[k]); }
    double slope_roundness(int k) const {
        const double s2 = s_[k] * s_[k], wc = w_[k] + c_[k];
        return -conic_.radius * s2 * s2 / (2.0 * w_[k] * wc * wc);
    }

  private:
    static constexpr int most_newton_steps = 30;
    static constexpr double last_newton_step = 1e-4;  // of the normal: the next would be below 1e-8
    static constexpr double arrived = 1e-12;

    void approach(const Lanes& u, const Lanes& v) {
        Lanes moving = Lanes::Ones();
        for (int step = 0; step < most_newton_steps; ++step) {
            place();
            const Lanes du = u + depth_, dv = v - y_;
            const Lanes speed = conic_.radius / (w_ * w_ * w_), stretch = speed + c_ * du + s_ * dv;
            Lanes turn = ((c_ * dv - s_ * du) / stretch.max(0.1 * speed)).max(-0.3).min(0.3);
            bool any = false;
            for (int k = 0; k < N; ++k) {
                const double size = std::abs(turn[k]);
                if (moving[k] == 0.0 || size < arrived) turn[k] = 0.0;
                if (!(size >= last_newton_step)) moving[k] = 0.0;
                any = any || moving[k] != 0.0;
            }
            const Lanes scale = 1.0 / (1.0 + turn * turn).sqrt(), turned = (c_ - s_ * turn) * scale;
            s_ = (s_ + c_ * turn) * scale;
            c_ = turned;
            if (!any) break;
        }
        place();
    }

    void place() {
        w_ = conic_support(Lanes(c_ * c_), conic_.roundness);
        depth_ = conic_.radius * s_ * s_ / (w_ * (w_ + c_).max(1e-3));
        y_ = conic_.radius * s_ / w_;
    }

    const VertexConic conic_;
    Vec2 side_;
    Lanes c_, s_, w_, depth_, y_;
};

}  // namespace cmm::fitting
