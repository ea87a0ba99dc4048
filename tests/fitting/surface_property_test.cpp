// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fitting/surface_index.hpp"
#include "support/random_values.hpp"

namespace cmm::fitting {
namespace {

std::vector<double> any_breaks(int spans) {
    std::vector<double> breaks{*real(-3.0, 3.0)};
    for (int k = 0; k < spans; ++k)
        breaks.push_back(breaks.back() + *real(0.05, 2.0));
    return breaks;
}

Surface any_surface() {
    const bool closed = *rc::gen::arbitrary<bool>();
    const CubicAxis u = *CubicAxis::on_breaks(any_breaks(*whole(4, 12)), closed);
    const CubicAxis v = *CubicAxis::on_breaks(any_breaks(*whole(1, 6)), false);
    std::vector<Vec3> controls;  // a dented tube, or half of one
    for (std::size_t j = 0; j < v.controls(); ++j)
        for (std::size_t i = 0; i < u.controls(); ++i) {
            const double angle = (closed ? 2 : 1) * std::numbers::pi * double(i) / double(u.controls());
            const double r = *real(3.0, 6.0), z = 8.0 * double(j) / double(v.controls()) - 4.0;
            controls.emplace_back(r * std::cos(angle), r * std::sin(angle), z + *real(-0.5, 0.5));
        }
    return *Surface::make(u, v, controls);
}

RC_GTEST_PROP(SurfaceProperties, LiesWithinItsControls, ()) {
    const Surface s = any_surface();
    const Vec3 p = s.position({*real(s.u().front(), s.u().back()), *real(s.v().front(), s.v().back())});
    RC_ASSERT(p.cwiseAbs().maxCoeff() <= 9.0 + 1e-12);
}

RC_GTEST_PROP(SurfaceProperties, AKnotChangesNothing, ()) {
    const Surface s = any_surface();
    const double u = *real(s.u().front(), s.u().back()), v = *real(s.v().front(), s.v().back());
    const auto more = s.with_knot_u(u);
    RC_PRE(more.has_value());
    const auto most = more->with_knot_v(v);
    RC_PRE(most.has_value());
    const SurfacePlace at{*real(s.u().front(), s.u().back()), *real(s.v().front(), s.v().back())};
    RC_ASSERT((s.position(at) - most->position(at)).norm() < 1e-10);
}

RC_GTEST_PROP(SurfaceProperties, NoPlaceIsNearerThanTheFoot, ()) {
    const Surface s = any_surface();
    const SurfaceIndex index(s);
    const Vec3 p(*real(-12, 12), *real(-12, 12), *real(-12, 12));
    const SurfacePlace hint{*real(s.u().front(), s.u().back()), *real(s.v().front(), s.v().back())};
    const SurfaceFoot foot = index.closest(p, hint);
    RC_ASSERT(std::abs((s.position(foot.place) - p).squaredNorm() - foot.squared) < 1e-9);
    double least = std::numeric_limits<double>::infinity();
    for (int j = 0; j <= 24; ++j)
        for (int i = 0; i < 60; ++i)
            least = std::min(least, (s.position({s.u().front() + (s.u().back() - s.u().front()) * i / 60,
                                                 s.v().front() + (s.v().back() - s.v().front()) * j / 24}) -
                                     p)
                                        .norm());
    RC_ASSERT(std::sqrt(foot.squared) <= least + 1e-6);
    RC_ASSERT(std::abs(std::sqrt(index.closest(p).squared) - std::sqrt(foot.squared)) < 2e-6);
}

}  // namespace
}  // namespace cmm::fitting
