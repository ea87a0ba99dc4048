// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "fitting/cyclic.hpp"

namespace cmm::fitting {

using core::ErrorCode;

Vec3 SurfaceJet::normal() const {
    const Vec3 across = du.cross(dv);
    const double length = across.norm();
    return length > 0.0 ? Vec3(across / length) : Vec3(Vec3::Zero());
}

std::pair<Vec3, Vec3> SurfaceJet::normal_derivatives() const {
    const Vec3 across = du.cross(dv);
    const double length = across.norm();
    if (!(length > 0.0)) return {Vec3::Zero(), Vec3::Zero()};
    const Vec3 n = across / length;
    const Vec3 by_u = duu.cross(dv) + du.cross(duv), by_v = duv.cross(dv) + du.cross(dvv);
    return {(by_u - n * n.dot(by_u)) / length, (by_v - n * n.dot(by_v)) / length};
}

/// From the first and second fundamental forms (do Carmo 1976, section 3.3), the sign turned.
PrincipalCurvatures SurfaceJet::curvatures() const {
    const Vec3 n = normal();
    const double e = du.squaredNorm(), f = du.dot(dv), g = dv.squaredNorm(), area = e * g - f * f;
    if (!(area > 0.0)) return {};
    const double l = -duu.dot(n), m = -duv.dot(n), k = -dvv.dot(n);
    const double mean = 0.5 * (l * g - 2.0 * m * f + k * e) / area, gauss = (l * k - m * m) / area;
    const double root = std::sqrt(std::max(mean * mean - gauss, 0.0));
    return {mean + root, mean - root};
}

core::Result<Surface> Surface::make(CubicAxis u, CubicAxis v, std::vector<Vec3> controls) {
    const auto refuse = [](const std::string& why) {
        return core::fail(ErrorCode::fit_not_evaluable, "surface: " + why);
    };
    if (u.spans() == 0 || v.spans() == 0) return refuse("no spans");
    if (v.closed()) return refuse("closed in v");
    if (controls.size() != u.controls() * v.controls()) return refuse("knots and controls do not belong together");
    Surface surface;
    const std::size_t n = u.controls();
    surface.stride_ = n + (u.closed() ? 3 : 0);
    surface.controls_.reserve(surface.stride_ * v.controls());
    for (std::size_t j = 0; j < v.controls(); ++j)
        for (std::size_t i = 0; i < surface.stride_; ++i) {
            const Vec3& c = controls[j * n + cyclic(i, n)];
            if (!c.allFinite()) return refuse("a control is not finite");
            surface.controls_.emplace_back(c.x(), c.y(), c.z(), 0.0);
        }
    surface.u_ = std::move(u);
    surface.v_ = std::move(v);
    return surface;
}

Vec3 Surface::position_in(std::size_t span_u, std::size_t span_v, const SurfacePlace& at) const {
    const auto wu = u_.weights(span_u, at.u), wv = v_.weights(span_v, at.v);
    Four sum = Four::Zero();
    for (std::size_t b = 0; b < 4; ++b) {
        const Four* c = row(v_.first(span_v) + b) + u_.first(span_u);
        sum += wv.value[static_cast<int>(b)] *
               (wu.value[0] * c[0] + wu.value[1] * c[1] + wu.value[2] * c[2] + wu.value[3] * c[3]);
    }
    return sum.matrix().head<3>();
}

SurfaceJet Surface::jet_in(std::size_t span_u, std::size_t span_v, const SurfacePlace& at) const {
    const auto wu = u_.weights(span_u, at.u), wv = v_.weights(span_v, at.v);
    Four s = Four::Zero(), su = s, sv = s, suu = s, suv = s, svv = s;
    for (int b = 0; b < 4; ++b) {
        const Four* c = row(v_.first(span_v) + static_cast<std::size_t>(b)) + u_.first(span_u);
        const Four r = wu.value[0] * c[0] + wu.value[1] * c[1] + wu.value[2] * c[2] + wu.value[3] * c[3];
        const Four ru = wu.d1[0] * c[0] + wu.d1[1] * c[1] + wu.d1[2] * c[2] + wu.d1[3] * c[3];
        const Four ruu = wu.d2[0] * c[0] + wu.d2[1] * c[1] + wu.d2[2] * c[2] + wu.d2[3] * c[3];
        s += wv.value[b] * r;
        su += wv.value[b] * ru;
        suu += wv.value[b] * ruu;
        sv += wv.d1[b] * r;
        suv += wv.d1[b] * ru;
        svv += wv.d2[b] * r;
    }
    const auto cut = [](const Four& value) -> Vec3 { return value.matrix().head<3>(); };
    return {cut(s), cut(su), cut(sv), cut(suu), cut(suv), cut(svv)};
}

Vec3 Surface::position(const SurfacePlace& at) const {
    const SurfacePlace p{u_.inside(at.u), v_.inside(at.v)};
    return position_in(u_.span_of(p.u, u_.spans() / 2), v_.span_of(p.v, v_.spans() / 2), p);
}

SurfaceJet Surface::jet(const SurfacePlace& at) const {
    const SurfacePlace p{u_.inside(at.u), v_.inside(at.v)};
    return jet_in(u_.span_of(p.u, u_.spans() / 2), v_.span_of(p.v, v_.spans() / 2), p);
}

void Surface::jets(std::span<const SurfacePlace> places, std::span<SurfaceJet> jets) const {
    std::size_t i = 0, j = 0;
    for (std::size_t k = 0; k < places.size(); ++k) {
        const SurfacePlace p{u_.inside(places[k].u), v_.inside(places[k].v)};
        i = u_.span_of(p.u, i);
        j = v_.span_of(p.v, j);
        jets[k] = jet_in(i, j, p);
    }
}

BSpline<3> Surface::row_curve(std::size_t j) const {
    std::vector<Vec3> controls(u_.controls());
    for (std::size_t i = 0; i < controls.size(); ++i)
        controls[i] = control(i, j);
    return *BSpline<3>::make(3, u_.knots(), std::move(controls), u_.closed());
}

BSpline<3> Surface::column_curve(std::size_t i) const {
    std::vector<Vec3> controls(v_.controls());
    for (std::size_t j = 0; j < controls.size(); ++j)
        controls[j] = control(i, j);
    return *BSpline<3>::make(3, v_.knots(), std::move(controls), false);
}

BSpline<3> Surface::curve_along_v(double u) const {
    const double at = u_.inside(u);
    const std::size_t span = u_.span_of(at, u_.spans() / 2);
    const auto w = u_.weights(span, at);
    std::vector<Vec3> controls(v_.controls());
    for (std::size_t j = 0; j < controls.size(); ++j) {
        const Four* c = row(j) + u_.first(span);
        const Four sum = w.value[0] * c[0] + w.value[1] * c[1] + w.value[2] * c[2] + w.value[3] * c[3];
        controls[j] = sum.matrix().head<3>();
    }
    return *BSpline<3>::make(3, v_.knots(), std::move(controls), false);
}

BSpline<3> Surface::curve_along_u(double v) const {
    const double at = v_.inside(v);
    const std::size_t span = v_.span_of(at, v_.spans() / 2);
    const auto w = v_.weights(span, at);
    std::vector<Vec3> controls(u_.controls(), Vec3::Zero());
    for (int b = 0; b < 4; ++b)
        for (std::size_t i = 0; i < controls.size(); ++i)
            controls[i] += w.value[b] * control(i, v_.first(span) + static_cast<std::size_t>(b));
    return *BSpline<3>::make(3, u_.knots(), std::move(controls), u_.closed());
}

core::Result<Surface> Surface::with_knot_u(double u) const {
    std::vector<Vec3> controls;
    std::vector<double> knots;
    for (std::size_t j = 0; j < v_.controls(); ++j) {
        auto curve = row_curve(j).with_knot(u);
        if (!curve) return tl::unexpected(curve.error());
        controls.insert(controls.end(), curve->controls().begin(), curve->controls().end());
        knots = curve->knots();
    }
    return CubicAxis::make(std::move(knots), u_.closed()).and_then([&](CubicAxis axis) {
        return make(std::move(axis), v_, std::move(controls));
    });
}

core::Result<Surface> Surface::with_knot_v(double v) const {
    const std::size_t n = u_.controls();
    std::vector<Vec3> controls(n * (v_.controls() + 1));
    std::vector<double> knots;
    for (std::size_t i = 0; i < n; ++i) {
        auto curve = column_curve(i).with_knot(v);
        if (!curve) return tl::unexpected(curve.error());
        for (std::size_t j = 0; j < curve->controls().size(); ++j)
            controls[j * n + i] = curve->controls()[j];
        knots = curve->knots();
    }
    return CubicAxis::make(std::move(knots), false).and_then([&](CubicAxis axis) {
        return make(u_, std::move(axis), std::move(controls));
    });
}

}  // namespace cmm::fitting
