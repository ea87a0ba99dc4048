// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/rng.hpp"
#include "support/surfaces.hpp"

namespace cmm::fitting {
namespace {

constexpr double turn = 2 * std::numbers::pi;

Vec3 on_cylinder(double u, double v) {
    return {5 * std::cos(u), 5 * std::sin(u), v};
}
/// A twisted elliptic column, no symmetry left.
Vec3 on_column(double u, double v) {
    const Eigen::Rotation2Dd twist(0.04 * v);
    Vec3 p(0, 0, v + 0.3 * std::sin(u));
    p.head<2>() = twist * Eigen::Vector2d((9 - 0.1 * v) * std::cos(u), 2 * std::sin(u)) + Eigen::Vector2d(0.1 * v, 0);
    return p;
}
Vec3 on_torus(double u, double v) {
    const double r = 8 + 2 * std::cos(v - 1);
    return {r * std::cos(u), r * std::sin(u), 2 * std::sin(v - 1)};
}

TEST(Surface, DerivativesAreThoseOfThePosition) {
    const Surface s = spline_of(on_column, turn, 60, true, 20, 12);
    core::Rng rng(4);
    for (int k = 0; k < 200; ++k) {
        const double h = 1e-4, u = rng.uniform(-3, 9), v = rng.uniform(0.01, 19.99);
        const SurfaceJet jet = s.jet({u, v});
        const auto at = [&](double a, double b) { return s.position({u + a * h, v + b * h}); };
        EXPECT_LT((jet.position - at(0, 0)).norm(), 1e-13);
        EXPECT_LT((jet.du - (at(1, 0) - at(-1, 0)) / (2 * h)).norm(), 1e-6);
        EXPECT_LT((jet.dv - (at(0, 1) - at(0, -1)) / (2 * h)).norm(), 1e-6);
        EXPECT_LT((jet.duu - (at(1, 0) + at(-1, 0) - 2 * at(0, 0)) / (h * h)).norm(), 1e-2);
        EXPECT_LT((jet.dvv - (at(0, 1) + at(0, -1) - 2 * at(0, 0)) / (h * h)).norm(), 1e-2);
        EXPECT_LT((jet.duv - (at(1, 1) + at(-1, -1) - at(1, -1) - at(-1, 1)) / (4 * h * h)).norm(), 1e-5);
        const auto [nu, nv] = jet.normal_derivatives();
        EXPECT_LT((nu - (s.jet({u + h, v}).normal() - s.jet({u - h, v}).normal()) / (2 * h)).norm(), 1e-4);
        EXPECT_LT((nv - (s.jet({u, v + h}).normal() - s.jet({u, v - h}).normal()) / (2 * h)).norm(), 1e-4);
    }
}

TEST(Surface, FollowsTheRecursionOfItsCurves) {
    const Surface s = spline_of(on_column, turn, 24, true, 20, 7);
    core::Rng rng(5);
    std::vector<SurfacePlace> places;
    for (int k = 0; k < 300; ++k) {
        const SurfacePlace at{rng.uniform(0, turn), rng.uniform(0, 20)};
        EXPECT_LT((s.position(at) - s.curve_along_v(at.u).position(at.v)).norm(), 1e-12);
        EXPECT_LT((s.position(at) - s.curve_along_u(at.v).position(at.u)).norm(), 1e-12);
        places.push_back(at);
    }
    std::vector<SurfaceJet> jets(places.size());
    s.jets(places, jets);
    for (std::size_t k = 0; k < places.size(); ++k) {
        EXPECT_EQ(jets[k].position, s.jet(places[k]).position);
        EXPECT_EQ(jets[k].duv, s.jet(places[k]).duv);
    }
}

TEST(Surface, CurvaturesOfKnownSurfaces) {
    const Surface cylinder = spline_of(on_cylinder, turn, 400, true, 10, 8);
    const Surface torus = spline_of(on_torus, turn, 400, true, 2, 120);
    core::Rng rng(6);
    for (int k = 0; k < 100; ++k) {
        const double u = rng.uniform(0, turn), v = rng.uniform(0, 2);
        const SurfaceJet on_c = cylinder.jet({u, 5 * v}), on_t = torus.jet({u, v});
        EXPECT_LT((on_c.position - on_cylinder(u, 5 * v)).norm(), 1e-8);
        EXPECT_LT((on_c.normal() - Vec3(std::cos(u), std::sin(u), 0)).norm(), 1e-7);
        EXPECT_NEAR(on_c.curvatures().largest, 0.2, 1e-4);
        EXPECT_NEAR(on_c.curvatures().smallest, 0.0, 1e-6);
        EXPECT_NEAR(on_t.curvatures().largest, 0.5, 1e-3);
        EXPECT_NEAR(on_t.curvatures().smallest, std::cos(v - 1) / (8 + 2 * std::cos(v - 1)), 1e-3);
        EXPECT_NEAR(on_t.curvatures().gauss(), on_t.curvatures().largest * on_t.curvatures().smallest, 1e-12);
    }
}

TEST(Surface, KnotInsertionChangesNothing) {
    Surface s = spline_of(on_column, turn, 16, true, 20, 6);
    const Surface original = s;
    core::Rng rng(7);
    for (int k = 0; k < 12; ++k) {
        const auto next =
            k % 2 == 0 ? s.with_knot_u(rng.uniform(0.01, turn - 0.01)) : s.with_knot_v(rng.uniform(0.1, 19.9));
        ASSERT_TRUE(next) << next.error().message;
        s = *next;
    }
    EXPECT_EQ(s.u().controls(), 22U);
    EXPECT_EQ(s.v().controls(), 15U);
    for (int k = 0; k < 500; ++k) {
        const SurfacePlace at{rng.uniform(0, turn), rng.uniform(0, 20)};
        EXPECT_LT((s.position(at) - original.position(at)).norm(), 1e-12);
    }
    EXPECT_FALSE(s.with_knot_u(9.0));
    EXPECT_FALSE(s.with_knot_v(-1.0));
}

TEST(Surface, RefusesWhatIsNoSurface) {
    const std::vector<double> breaks{0, 1, 2, 3, 4};
    const CubicAxis u = *CubicAxis::on_breaks(breaks, true), v = *CubicAxis::on_breaks(breaks, false);
    EXPECT_EQ(u.controls(), 4U);
    EXPECT_EQ(v.controls(), 7U);
    std::vector<Vec3> controls(28, Vec3::Ones());
    EXPECT_TRUE(Surface::make(u, v, controls));
    EXPECT_FALSE(Surface::make(v, u, controls)) << "closed in v";
    controls[3].y() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(Surface::make(u, v, controls));
    controls.pop_back();
    EXPECT_FALSE(Surface::make(u, v, controls));
    EXPECT_FALSE(CubicAxis::on_breaks({0, 1, 1, std::nan(""), 3}, true));
    EXPECT_FALSE(CubicAxis::on_breaks({0, 1}, true));
    EXPECT_FALSE(CubicAxis::on_breaks({}, false));
    EXPECT_EQ(u.inside(std::nan("")), 0.0);
    EXPECT_NEAR(u.inside(-0.5), 3.5, 1e-15);
    EXPECT_EQ(v.inside(7.0), 4.0);
}

}  // namespace
}  // namespace cmm::fitting
