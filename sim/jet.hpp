// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

namespace cmm::sim {

/// A number with its first and second derivatives in two variables u, v (second-order forward differentiation): a
/// formula written once over a template gives the point of a surface and what Newton's method needs. A value; any
/// thread.
struct Jet {
    double f = 0.0, u = 0.0, v = 0.0, uu = 0.0, uv = 0.0, vv = 0.0;

    Jet() = default;
    Jet(double value) : f(value) {}  // NOLINT(google-explicit-constructor): constants mix with jets in formulas
    Jet(double value, double du, double dv) : f(value), u(du), v(dv) {}
    Jet(double value, double du, double dv, double duu, double duv, double dvv)
        : f(value), u(du), v(dv), uu(duu), uv(duv), vv(dvv) {}
};

/// g(x) from g, g', g'' at x.f: the chain rule of second order.
inline Jet chain(const Jet& x, double g, double g1, double g2) {
    return {g, g1 * x.u, g1 * x.v, g1 * x.uu + g2 * x.u * x.u, g1 * x.uv + g2 * x.u * x.v, g1 * x.vv + g2 * x.v * x.v};
}
inline Jet operator+(const Jet& a, const Jet& b) {
    return {a.f + b.f, a.u + b.u, a.v + b.v, a.uu + b.uu, a.uv + b.uv, a.vv + b.vv};
}
inline Jet operator-(const Jet& a, const Jet& b) {
    return {a.f - b.f, a.u - b.u, a.v - b.v, a.uu - b.uu, a.uv - b.uv, a.vv - b.vv};
}
inline Jet operator-(const Jet& a) {
    return {-a.f, -a.u, -a.v, -a.uu, -a.uv, -a.vv};
}
inline Jet operator*(double k, const Jet& a) {
    return {k * a.f, k * a.u, k * a.v, k * a.uu, k * a.uv, k * a.vv};
}
inline Jet operator*(const Jet& a, double k) {
    return k * a;
}
inline Jet operator*(const Jet& a, const Jet& b) {
    return {a.f * b.f,
            a.u * b.f + a.f * b.u,
            a.v * b.f + a.f * b.v,
            a.uu * b.f + 2.0 * a.u * b.u + a.f * b.uu,
            a.uv * b.f + a.u * b.v + a.v * b.u + a.f * b.uv,
            a.vv * b.f + 2.0 * a.v * b.v + a.f * b.vv};
}
inline Jet operator/(const Jet& a, const Jet& b) {
    const double r = 1.0 / b.f;
    return a * chain(b, r, -r * r, 2.0 * r * r * r);
}
inline Jet sqrt(const Jet& x) {
    const double root = std::sqrt(x.f);
    return chain(x, root, 0.5 / root, -0.25 / (root * x.f));
}
inline Jet sin(const Jet& x) {
    return chain(x, std::sin(x.f), std::cos(x.f), -std::sin(x.f));
}
inline Jet cos(const Jet& x) {
    return chain(x, std::cos(x.f), -std::sin(x.f), -std::cos(x.f));
}
inline Jet acos(const Jet& x) {
    const double w = 1.0 - x.f * x.f, root = std::sqrt(w);
    return chain(x, std::acos(x.f), -1.0 / root, -x.f / (w * root));
}

}  // namespace cmm::sim
