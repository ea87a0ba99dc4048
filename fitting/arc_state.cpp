// SPDX-License-Identifier: Apache-2.0
#include "fitting/arc_state.hpp"

#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double series_tangent = 0.1;  // below it four terms give atan(t)/t to 1e-9

/// A displacement d obeys d'' + curvature^2 d = change of curvature, so that over the arc
/// d = cos d0 + reach d0' + rise dk, d' = -sink d0 + cos d0' + reach dk.
struct Transition {
    double cosine, reach, rise, sink;
};

Transition transition(const ArcState& state, const ArcFoot& foot) {
    return {foot.cosine, foot.reach, foot.reach * foot.reach / (1.0 + foot.cosine),
            state.curvature * state.curvature * foot.reach};
}

/// F P: rows displacement, slope, curvature.
Matrix3 transported(const Transition& f, const Symmetric3& p) {
    return {{{f.cosine * p.dd + f.reach * p.ds + f.rise * p.dc, f.cosine * p.ds + f.reach * p.ss + f.rise * p.sc,
              f.cosine * p.dc + f.reach * p.sc + f.rise * p.cc},
             {-f.sink * p.dd + f.cosine * p.ds + f.reach * p.dc, -f.sink * p.ds + f.cosine * p.ss + f.reach * p.sc,
              -f.sink * p.dc + f.cosine * p.sc + f.reach * p.cc},
             {p.dc, p.sc, p.cc}}};
}

/// Zero for what rounding leaves of a direction without variance.
double inverse_pivot(double pivot, double diagonal) {
    return pivot > 1e-14 * diagonal ? 1.0 / pivot : 0.0;
}

}  // namespace

ArcFoot foot_on_arc(const ArcState& state, const Vec2& point) {
    ArcFoot foot;
    const Vec2 apart = point - state.position;
    const double k = state.curvature, along = apart.dot(state.tangent), across = cross(state.tangent, apart);
    const double towards = 1.0 - k * across;
    if (!(towards > 0.0)) return foot;
    // Distance from the circle without cancellation: (1 - root)/k with root^2 = 1 + 2 k w.
    const double w = 0.5 * k * (along * along + across * across) - across;
    const double root = std::sqrt(1.0 + 2.0 * k * w);
    foot.reached = true;
    foot.offset = -2.0 * w / (1.0 + root);
    foot.cosine = towards / root;
    foot.reach = along / root;
    const double sine = k * foot.reach, t = k * along / towards, tt = t * t;
    foot.tangent = foot.cosine * state.tangent + sine * left_of(state.tangent);
    const double share =
        std::abs(t) < series_tangent ? 1.0 - tt * (1.0 / 3.0 - tt * (1.0 / 5.0 - tt * (1.0 / 7.0))) : std::atan(t) / t;
    foot.length = along / towards * share;
    foot.turn = k * foot.length;
    return foot;
}

double process_variance(double rate, double length) {
    const double l = std::abs(length), square = l * l;
    return rate * square * square * l / 20.0;
}

double carried_variance(const ArcState& state, const ArcFoot& foot) {
    const Transition f = transition(state, foot);
    const Symmetric3& p = state.covariance;
    return f.cosine * (f.cosine * p.dd + 2.0 * (f.reach * p.ds + f.rise * p.dc)) +
           f.reach * (f.reach * p.ss + 2.0 * f.rise * p.sc) + f.rise * f.rise * p.cc;
}

Symmetric3 carried_covariance(const ArcState& state, const ArcFoot& foot, double rate) {
    const Transition f = transition(state, foot);
    const Matrix3 a = transported(f, state.covariance);
    // Process noise of an integrated Wiener process (Wecker and Ansley 1983, one order higher).
    const double l = std::abs(foot.length), l2 = l * l, sign = std::copysign(1.0, foot.length), noise = rate * l;
    Symmetric3 p;
    p.dd = a[0][0] * f.cosine + a[0][1] * f.reach + a[0][2] * f.rise + noise * l2 * l2 / 20.0;
    p.ds = -a[0][0] * f.sink + a[0][1] * f.cosine + a[0][2] * f.reach + sign * noise * l2 * l / 8.0;
    p.dc = a[0][2] + noise * l2 / 6.0;
    p.ss = -a[1][0] * f.sink + a[1][1] * f.cosine + a[1][2] * f.reach + noise * l2 / 3.0;
    p.sc = a[1][2] + sign * noise * l / 2.0;
    p.cc = a[2][2] + noise;
    return p;
}

ArcState displaced(const ArcState& state, const Triple& by) {
    ArcState moved = state;
    const Vec2 left = left_of(state.tangent);
    moved.position += by[0] * left;
    moved.tangent = (state.tangent + by[1] * left) / std::sqrt(1.0 + by[1] * by[1]);
    moved.curvature += by[2];
    return moved;
}

ArcUpdate updated(const ArcState& before, const ArcFoot& foot, const Vec2& point, const Symmetric3& predicted,
                  double noise) {
    const Symmetric3& p = predicted;
    const double share = 1.0 / (p.dd + noise), rest = noise * share;
    const Triple by{p.dd * share * foot.offset, p.ds * share * foot.offset, p.dc * share * foot.offset};
    const ArcState at{point - foot.offset * left_of(foot.tangent),
                      foot.tangent,
                      before.curvature,
                      {p.dd * rest, p.ds * rest, p.dc * rest, p.ss - p.ds * p.ds * share, p.sc - p.ds * p.dc * share,
                       p.cc - p.dc * p.dc * share}};
    return {displaced(at, by), by};
}

Matrix3 backward_gain(const ArcState& state, const ArcFoot& foot, const Symmetric3& predicted) {
    const Matrix3 a = transported(transition(state, foot), state.covariance);
    const Symmetric3& p = predicted;
    const double pivot0 = inverse_pivot(p.dd, p.dd), l10 = p.ds * pivot0, l20 = p.dc * pivot0;
    const double pivot1 = inverse_pivot(p.ss - l10 * p.ds, p.ss), u21 = p.sc - l20 * p.ds, l21 = u21 * pivot1;
    const double pivot2 = inverse_pivot(p.cc - l20 * p.dc - l21 * u21, p.cc);
    Matrix3 gain;
    for (std::size_t k = 0; k < 3; ++k) {
        const double x0 = a[0][k], x1 = a[1][k] - l10 * x0, x2 = a[2][k] - l20 * x0 - l21 * x1;
        const double z2 = x2 * pivot2, z1 = x1 * pivot1 - l21 * z2;
        gain[k] = {x0 * pivot0 - l10 * z1 - l20 * z2, z1, z2};
    }
    return gain;
}

Triple product(const Matrix3& m, const Triple& v) {
    return {m[0][0] * v[0] + m[0][1] * v[1] + m[0][2] * v[2], m[1][0] * v[0] + m[1][1] * v[1] + m[1][2] * v[2],
            m[2][0] * v[0] + m[2][1] * v[1] + m[2][2] * v[2]};
}

Symmetric3 smoothed_covariance(const Symmetric3& p, const Matrix3& gain, const Symmetric3& later,
                               const Symmetric3& predicted) {
    const double dd = later.dd - predicted.dd, ds = later.ds - predicted.ds, dc = later.dc - predicted.dc;
    const double ss = later.ss - predicted.ss, sc = later.sc - predicted.sc, cc = later.cc - predicted.cc;
    const Matrix3 change{{{dd, ds, dc}, {ds, ss, sc}, {dc, sc, cc}}};
    const Triple r0 = product(change, gain[0]), r1 = product(change, gain[1]), r2 = product(change, gain[2]);
    const auto dot = [](const Triple& a, const Triple& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    return {p.dd + dot(gain[0], r0), p.ds + dot(gain[0], r1), p.dc + dot(gain[0], r2),
            p.ss + dot(gain[1], r1), p.sc + dot(gain[1], r2), p.cc + dot(gain[2], r2)};
}

}  // namespace cmm::fitting
