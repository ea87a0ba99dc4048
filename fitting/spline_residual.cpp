// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline_residual.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double settled_share = 1e-4;  // of the gap: a Newton step so short is the last

/// N residuals side by side. Two components of a vector are two lanes.
template <int N>
class Residuals {
  public:
    using Lanes = Eigen::Array<double, N, 1>;
    struct Pair {
        Lanes x, y;
        Pair operator-(const Pair& o) const { return {x - o.x, y - o.y}; }
        Pair operator+(const Pair& o) const { return {x + o.x, y + o.y}; }
        Pair operator*(const Lanes& by) const { return {x * by, y * by}; }
        Lanes dot(const Pair& o) const { return x * o.x + y * o.y; }
        Lanes cross(const Pair& o) const { return x * o.y - y * o.x; }
        Lanes norm() const { return dot(*this).sqrt(); }
        /// Points `at(k)`.
        static Pair of(const auto& at) {
            Pair pair;
            for (int k = 0; k < N; ++k) {
                pair.x[k] = at(k).x();
                pair.y[k] = at(k).y();
            }
            return pair;
        }
    };

    Residuals(const Pair& a, const Pair& b, const Pair& c, const Pair& d, const Pair& p) {
        const Pair ab = b - a, bc = c - b, cd = d - c;
        const Lanes h0 = ab.norm(), gap = bc.norm(), h2 = cd.norm();
        // The turn over the gap, as its share of the turn between the outer chords.
        Lanes whole_turn = ab.cross(cd) / (h0 * h2);
        const Lanes along = ab.dot(cd);
        for (int k = 0; k < N; ++k)
            if (!(along[k] > 0.0)) whole_turn[k] = std::copysign(1.5, whole_turn[k]);
        const Lanes turn = whole_turn * gap / (gap + 0.5 * (h0 + h2));
        // s = c (g/2) / sin(g/2) = c (1 + g^2/24 + ...), enough up to a radian
        const Lanes h1 = gap * (1.0 + turn * turn / 24.0);
        // Newton's divided differences over -h0, 0, h1, h1 + h2 (b is the origin).
        const Lanes ac = h0 + h1, bd = h1 + h2, ad = ac + h2;
        const Lanes per_h0 = 1.0 / h0, per_h1 = 1.0 / h1, per_h2 = 1.0 / h2;
        const Lanes per_ac = 1.0 / ac, per_bd = 1.0 / bd, per_ad = 1.0 / ad;
        const Pair s0 = ab * per_h0, s1 = bc * per_h1, s2 = cd * per_h2;
        const Pair q0 = (s1 - s0) * per_ac, q1 = (s2 - s1) * per_bd, cubic = (q1 - q0) * per_ad;
        Lanes t = ((p - b).dot(bc) / (gap * gap)).max(0.0).min(1.0) * h1;
        Pair off, slope;
        const auto look = [&] {
            const Lanes beyond = t - h1;
            off = p - (b + (s1 + (q0 + cubic * Lanes(t + h0)) * beyond) * t);
            slope = s1 + q0 * Lanes(2.0 * t - h1) + cubic * Lanes(3.0 * t * t + 2.0 * (h0 - h1) * t - h0 * h1);
        };
        const auto step = [&] { return Lanes(off.dot(slope) / slope.dot(slope).max(1e-12)); };
        look();
        const Lanes first = step();
        t = (t + first).max(-h0).min(bd);
        look();
        Lanes second = step();
        bool any = false;
        for (int k = 0; k < N; ++k) {
            if (std::abs(first[k]) < settled_share * h1[k]) second[k] = 0.0;
            any = any || second[k] != 0.0;
        }
        if (any) {
            t = (t + second).max(-h0).min(bd);
            look();
        }
        // The weights of a, b, c, d in the cubic (Lagrange) carry their noise into the distance.
        const Lanes ta = t + h0, tc = t - h1, td = t - bd;
        const Lanes wa = t * tc * td * per_h0 * per_ac * per_ad, wb = ta * tc * td * per_h0 * per_h1 * per_bd;
        const Lanes wc = ta * t * td * per_ac * per_h1 * per_h2, wd = ta * t * tc * per_ad * per_bd * per_h2;
        distance_ = off.norm();
        side_ = off.x * slope.y - off.y * slope.x;  // along the right-hand normal
        gain_ = (1.0 + wa * wa + wb * wb + wc * wc + wd * wd).sqrt();
    }

    SplineResidual at(int k) const { return {std::copysign(distance_[k], side_[k]), gain_[k]}; }

  private:
    Lanes distance_, side_, gain_;
};

}  // namespace

SplineResidual spline_residual(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, const Vec2& p) {
    if (a == b || b == c || c == d) return {};
    using One = Residuals<1>;
    const auto one = [](const Vec2& v) { return One::Pair::of([&](int) -> const Vec2& { return v; }); };
    return One(one(a), one(b), one(c), one(d), one(p)).at(0);
}

EightResiduals spline_residuals(const Vec2* first, std::ptrdiff_t by) {
    using Eight = Residuals<8>;
    const auto eight = [&](std::ptrdiff_t steps) {
        return Eight::Pair::of([&](int k) -> const Vec2& { return first[k + steps * by]; });
    };
    const Eight found(eight(-2), eight(-1), eight(1), eight(2), eight(0));
    EightResiduals residuals;
    for (int k = 0; k < 8; ++k)
        residuals[static_cast<std::size_t>(k)] = found.at(k);
    return residuals;
}

}  // namespace cmm::fitting
