// SPDX-License-Identifier: Apache-2.0
#include "sim/parametric.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.hpp"

namespace cmm::sim {

using core::ErrorCode;
using core::fail;

namespace {

constexpr double straight_rad = 1e-9;  // below this turning angle the camber line is a straight line

/// The thickness law f(t) of the document, and its derivative.
template <class T>
T bulge(const T& t) {
    return 2.0 * t * (1.0 - t) + 27.0 / 8.0 * t * (1.0 - t) * (1.0 - t);
}
template <class T>
T bulge_slope(const T& t) {
    return 2.0 - 4.0 * t + 27.0 / 8.0 * (1.0 - t) * (1.0 - 3.0 * t);
}

template <class T>
struct Plane {
    T x, y;
};

}  // namespace

/// The lengths of the section at one height: everything but the turning angle is linear in z.
template <class T>
struct BladePatch::Section {
    double turning;          // camber angle th
    T k, length, r1, r2, h;  // chord between the circle centres, its arc length, end radii, thickness term

    Plane<T> camber(const T& t) const {
        using std::cos;
        using std::sin;
        if (std::abs(turning) < straight_rad) return {(t - 0.5) * k, T(0.0)};
        const T a = (t - 0.5) * turning;
        const double scale = 0.5 / std::sin(0.5 * turning);
        return {k * sin(a) * scale, k * (cos(a) - std::cos(0.5 * turning)) * scale};
    }
    T radius(const T& t) const { return r1 * (1.0 - t) + r2 * t + h * bulge(t); }
    T slope(const T& t) const { return (r2 - r1 + h * bulge_slope(t)) / length; }  // q = rho' / L
    /// A point in the camber line's own directions at t: `along` the tangent, `left` of it.
    Plane<T> from_camber(const T& t, const T& along, const T& left) const {
        using std::cos;
        using std::sin;
        const T a = (t - 0.5) * turning;
        const T c = cos(a), s = sin(a);
        const Plane<T> m = camber(t);
        return {m.x + along * c + left * s, m.y - along * s + left * c};
    }
    Plane<T> side(const T& t, double which) const {
        using std::sqrt;
        const T q = slope(t), rho = radius(t);
        return from_camber(t, -(rho * q), which * (rho * sqrt(1.0 - q * q)));
    }
    /// The arc of an end circle between the sides' ends; part -1 ... 1 runs counter-clockwise.
    Plane<T> arc(bool leading, const T& part) const {
        using std::acos;
        using std::cos;
        using std::sin;
        const T t(leading ? 0.0 : 1.0);
        const double outside = leading ? -1.0 : 1.0;
        const T half = acos(outside * -1.0 * slope(t));
        const T angle = part * half;
        return from_camber(t, outside * (radius(t) * cos(angle)), outside * (radius(t) * sin(angle)));
    }
};

template <class T>
BladePatch::Section<T> BladePatch::section(const T& z) const {
    const auto& n = numbers_;
    const T s = (z - n.z_root_mm) * (1.0 / (n.z_tip_mm - n.z_root_mm));
    const T chord = n.chord_root_mm + (n.chord_tip_mm - n.chord_root_mm) * s;
    const T thickness = n.thickness_root_mm + (n.thickness_tip_mm - n.thickness_root_mm) * s;
    Section<T> section{n.camber_rad, {}, {}, {}, {}, {}};
    section.r1 = (n.le_radius_mm / n.chord_root_mm) * chord;
    section.r2 = (n.te_radius_mm / n.chord_root_mm) * chord;
    section.k = chord - section.r1 - section.r2;
    const double half = 0.5 * n.camber_rad;
    section.length = (std::abs(half) < straight_rad ? 1.0 : half / std::sin(half)) * section.k;
    section.h = 0.5 * thickness - 0.5 * (section.r1 + section.r2);
    return section;
}

template <class T>
std::array<T, 3> BladePatch::evaluate(const T& u, double u_value, const T& z) const {
    using std::cos;
    using std::sin;
    const double period = u_breaks_.back();
    const double turns = std::floor(u_value / period) * period;
    const double within = u_value - turns;
    const auto above = std::upper_bound(u_breaks_.begin() + 1, u_breaks_.end() - 1, within);
    const auto piece = above - u_breaks_.begin() - 1;
    const double from = *(above - 1), to = *above;
    const T part = (u - (turns + from)) * (1.0 / (to - from));
    const Section<T> here = section(z);
    Plane<T> p{};
    switch (piece) {
        case 0:
            p = here.side(1.0 - part, 1.0);
            break;
        case 1:
            p = here.arc(true, 2.0 * part - 1.0);
            break;
        case 2:
            p = here.side(part, -1.0);
            break;
        default:
            p = here.arc(false, 2.0 * part - 1.0);
            break;
    }
    const auto& n = numbers_;
    const T rise = z - n.z_root_mm;
    const T g = n.stagger_root_rad + ((n.stagger_tip_rad - n.stagger_root_rad) / (n.z_tip_mm - n.z_root_mm)) * rise;
    const T c = cos(g), s = sin(g);
    return warp_(std::array<T, 3>{c * p.x - s * p.y + std::tan(n.lean_x_rad) * rise,
                                  s * p.x + c * p.y + std::tan(n.lean_y_rad) * rise, z});
}

Eigen::Vector3d BladePatch::point(double u, double v) const {
    const auto p = evaluate<double>(u, u, v);
    return {p[0], p[1], p[2]};
}

PatchPoint BladePatch::at(double u, double v) const {
    const auto p = evaluate<Jet>(Jet(u, 1.0, 0.0), u, Jet(v, 0.0, 1.0));
    return {{p[0].f, p[1].f, p[2].f},    {p[0].u, p[1].u, p[2].u},    {p[0].v, p[1].v, p[2].v},
            {p[0].uu, p[1].uu, p[2].uu}, {p[0].uv, p[1].uv, p[2].uv}, {p[0].vv, p[1].vv, p[2].vv}};
}

BladePatch::BladePatch(const BladeNumbers& numbers, double beyond_mm, const Warp& warp)
    : numbers_(numbers),
      warp_(warp),
      v_breaks_{numbers.z_root_mm - beyond_mm, numbers.z_root_mm, numbers.z_tip_mm, numbers.z_tip_mm + beyond_mm} {
    // Pieces as wide as they are long at mid height, so that a step in u means the same on both sides of a joint.
    const auto middle = section(0.5 * (numbers.z_root_mm + numbers.z_tip_mm));
    const double side = middle.length, le = std::numbers::pi * middle.r1, te = std::numbers::pi * middle.r2;
    u_breaks_ = {0.0, side, side + le, 2.0 * side + le, 2.0 * side + le + te};
}

core::Result<std::shared_ptr<const BladePatch>> BladePatch::make(const BladeNumbers& n, double beyond_mm,
                                                                 const Warp& warp) {
    if (!(n.z_tip_mm > n.z_root_mm)) return fail(ErrorCode::config_invalid, "z_tip_mm must be above z_root_mm");
    if (n.le_radius_mm <= 0.0 || n.te_radius_mm <= 0.0) {
        return fail(ErrorCode::config_invalid, "le_radius_mm and te_radius_mm must be above 0");
    }
    std::shared_ptr<const BladePatch> patch(new BladePatch(n, beyond_mm, warp));
    if (auto sound = patch->check(); !sound) return tl::unexpected(sound.error());
    return patch;
}

core::Status BladePatch::check() const {
    const auto at_height = [](double z) { return " at z = " + core::fixed(z, 3) + " mm"; };
    for (const double z : {v_breaks_.front(), v_breaks_.back()}) {  // linear between
        if (!(section(z).r1 > 0.0 && section(z).k > 0.0)) {
            return fail(ErrorCode::config_invalid, "the chord is too short for its edges" + at_height(z));
        }
    }
    for (int j = 0; j <= 8; ++j) {
        const double z = std::lerp(v_breaks_.front(), v_breaks_.back(), j / 8.0);
        const auto here = section(z);
        const std::string at = at_height(z);
        for (int i = 0; i <= 200; ++i) {
            const double t = i / 200.0, step = 1e-5;
            if (!(here.radius(t) > 0.0)) return fail(ErrorCode::config_invalid, "the blade has no thickness" + at);
            if (!(std::abs(here.slope(t)) < 0.999)) {
                return fail(ErrorCode::config_invalid, "the thickness grows too fast from an edge for its chord" + at);
            }
            if (i == 0 || i == 200) continue;
            for (const double which : {1.0, -1.0}) {  // a side that runs backwards has folded over itself
                const auto a = here.side(t - step, which), b = here.side(t + step, which);
                const double angle = (t - 0.5) * here.turning;
                if ((b.x - a.x) * std::cos(angle) - (b.y - a.y) * std::sin(angle) <= 0.0) {
                    return fail(ErrorCode::config_invalid, "the camber is too strong for the thickness" + at);
                }
            }
        }
    }
    return {};
}

}  // namespace cmm::sim
