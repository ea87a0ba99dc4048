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
    const double ac = h0 + h1, bd = h1 + h2, ad = ac + h2;
    const double per_h0 = 1.0 / h0, per_h1 = 1.0 / h1, per_h2 = 1.0 / h2, per_ac = 1.0 / ac, per_bd = 1.0 / bd,
                 per_ad = 1.0 / ad;
    const Vec2 s0 = ab * per_h0, s1 = bc * per_h1, s2 = cd * per_h2;
    const Vec2 q0 = (s1 - s0) * per_ac, q1 = (s2 - s1) * per_bd, cubic = (q1 - q0) * per_ad;
    double t = std::clamp((p - b).dot(bc) / (gap * gap), 0.0, 1.0) * h1;
    Vec2 off, slope;
    for (int step = 0;; ++step) {
        off = p - (b + t * (s1 + (t - h1) * (q0 + (t + h0) * cubic)));
        slope = s1 + (2.0 * t - h1) * q0 + (3.0 * t * t + 2.0 * (h0 - h1) * t - h0 * h1) * cubic;
        if (step == 2) break;
        const double move = off.dot(slope) / std::max(slope.squaredNorm(), 1e-12);
        t = std::clamp(t + move, -h0, bd);
        if (std::abs(move) < 1e-4 * h1) step = 1;
    }
    // The weights of a, b, c, d in the cubic (Lagrange) carry their noise into the distance.
    const double ta = t + h0, tc = t - h1, td = t - bd;
    const double wa = t * tc * td * per_h0 * per_ac * per_ad, wb = ta * tc * td * per_h0 * per_h1 * per_bd;
    const double wc = ta * t * td * per_ac * per_h1 * per_h2, wd = ta * t * tc * per_ad * per_bd * per_h2;
    return {std::copysign(off.norm(), off.dot(right_normal(slope))),
            std::sqrt(1.0 + wa * wa + wb * wb + wc * wc + wd * wd)};
}

}  // namespace cmm::fitting
