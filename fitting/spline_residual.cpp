// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline_residual.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

double arc_of_chord(double chord, double turn) {
    // s = c (g/2) / sin(g/2) = c (1 + g^2/24 + ...), enough up to a radian
    return chord * (1.0 + turn * turn / 24.0);
}

}  // namespace

SplineResidual spline_residual(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, const Vec2& p) {
    const Vec2 ab = b - a, bc = c - b, cd = d - c;
    const double h0 = ab.norm(), gap = bc.norm(), h2 = cd.norm();
    if (!(h0 > 0.0) || !(gap > 0.0) || !(h2 > 0.0)) return {};
    // The turn over the gap, as its share of the turn between the outer chords.
    const double sine = cross(ab, cd) / (h0 * h2), whole_turn = ab.dot(cd) > 0.0 ? sine : std::copysign(1.5, sine);
    const double h1 = arc_of_chord(gap, whole_turn * gap / (gap + 0.5 * (h0 + h2)));
    // Newton's divided differences over -h0, 0, h1, h1 + h2 (b is the origin).
    const Vec2 s0 = ab / h0, s1 = bc / h1, s2 = cd / h2;
    const Vec2 q0 = (s1 - s0) / (h0 + h1), q1 = (s2 - s1) / (h1 + h2);
    const Vec2 cubic = (q1 - q0) / (h0 + h1 + h2);
    const auto at = [&](double t) -> Vec2 { return b + t * (s1 + (t - h1) * (q0 + (t + h0) * cubic)); };
    const auto slope = [&](double t) -> Vec2 {
        return s1 + (2.0 * t - h1) * q0 + (3.0 * t * t + 2.0 * (h0 - h1) * t - h0 * h1) * cubic;
    };
    double t = std::clamp((p - b).dot(bc) / (gap * gap), 0.0, 1.0) * h1;
    for (int step = 0; step < 2; ++step) {
        const Vec2 v = slope(t);
        t = std::clamp(t + (p - at(t)).dot(v) / std::max(v.squaredNorm(), 1e-12), -h0, h1 + h2);
    }
    const Vec2 off = p - at(t);
    // The weights of a, b, c, d in the cubic (Lagrange) carry their noise into the distance.
    const double ta = t + h0, tc = t - h1, td = t - h1 - h2, ac = h0 + h1, ad = ac + h2, bd = h1 + h2;
    const double wa = -t * tc * td / (h0 * ac * ad), wb = ta * tc * td / (h0 * h1 * bd);
    const double wc = -ta * t * td / (ac * h1 * h2), wd = ta * t * tc / (ad * bd * h2);
    return {std::copysign(off.norm(), off.dot(right_normal(slope(t)))),
            std::sqrt(1.0 + wa * wa + wb * wb + wc * wc + wd * wd)};
}

}  // namespace cmm::fitting
