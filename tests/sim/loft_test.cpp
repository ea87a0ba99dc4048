// SPDX-License-Identifier: Apache-2.0
#include "sim/loft.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "core/rng.hpp"
#include "core/text.hpp"
#include "sim/contact.hpp"
#include "sim/profiles.hpp"
#include "sim/section_file.hpp"
#include "tests/sim/rotor37.hpp"

namespace cmm::sim {
namespace {

Points ellipse(double a, double b, double z, int n, double start = 0.0, bool clockwise = false) {
    Points p;
    for (int i = 0; i < n; ++i) {
        const double t = start + (clockwise ? -1.0 : 1.0) * 2.0 * std::numbers::pi * i / n;
        p.emplace_back(a * std::cos(t), b * std::sin(t), z);
    }
    return p;
}

TEST(Loft, CylinderHasItsAnalyticDistance) {
    const double radius = 8.0;
    // Any order, both directions.
    const auto patch = LoftPatch::make({ellipse(radius, radius, 30.0, 120), ellipse(radius, radius, 0.0, 120),
                                        ellipse(radius, radius, 12.0, 120, 0.0, true)},
                                       1.0);
    ASSERT_TRUE(patch) << patch.error().text();
    const PatchSurface surface(*patch);
    core::Rng rng(1);
    std::size_t warm = 0;
    for (int i = 0; i < 2000; ++i) {
        const double r = rng.uniform(4.0, 14.0), t = rng.uniform(0.0, 6.283), z = rng.uniform(5.0, 25.0);
        const Contact c = surface.nearest({r * std::cos(t), r * std::sin(t), z}, warm);
        EXPECT_NEAR(c.distance_mm, r - radius, 2e-6);  // the spline's own error, h^4 / 384
        EXPECT_NEAR(c.normal.dot(Eigen::Vector3d(std::cos(t), std::sin(t), 0.0)), 1.0, 1e-9);
    }
}

TEST(Loft, TwoProfilesAreRuledAndAConeTouchesByItsLean) {
    const double alpha = std::atan(4.0 / 20.0), r = 1.0;
    const auto patch = LoftPatch::make({ellipse(12.0, 12.0, 0.0, 160), ellipse(8.0, 8.0, 20.0, 160)}, r);
    ASSERT_TRUE(patch);
    const PatchSurface surface(*patch);
    std::size_t warm = 0;
    for (const double z : {0.2, 10.0, 19.9}) {  // near the ends the foot lies beyond the profile
        const auto ball = touch_along(surface, {15.0, 0.0, z}, -Eigen::Vector3d::UnitX(), 0.0, 10.0, r, warm);
        ASSERT_TRUE(ball);
        EXPECT_NEAR(ball->centre.x(), 12.0 - 0.2 * z + r / std::cos(alpha), 1e-5);
        EXPECT_NEAR(ball->foot.z(), z - r * std::sin(alpha), 1e-5);
    }
}

TEST(Loft, DerivativesAgreeWithDifferencesAndAreContinuous) {
    std::vector<Points> profiles;
    for (int k = 0; k < 5; ++k)
        profiles.push_back(ellipse(10.0 - k, 3.0 + 0.2 * k * k, 7.0 * k, 60, 0.05 * k));
    const auto patch = LoftPatch::make(profiles, 2.0).value();
    const double step = 1e-4, period = patch->u_breaks().back();
    for (double w = 0.0; w < 1.0; w += 0.043) {
        const double u = (w + 0.5) * period;
        const double v = std::lerp(patch->v_breaks().front() + 0.01, patch->v_breaks().back() - 0.01, w);
        const PatchPoint p = patch->at(u, v);
        const auto s = [&](double i, double j) { return patch->point(u + i * step, v + j * step); };
        EXPECT_LT((p.su - (s(1, 0) - s(-1, 0)) / (2 * step)).norm(), 1e-6);
        EXPECT_LT((p.sv - (s(0, 1) - s(0, -1)) / (2 * step)).norm(), 1e-6);
        EXPECT_LT((p.suu - (s(1, 0) - 2.0 * s(0, 0) + s(-1, 0)) / (step * step)).norm(), 1e-3);
        EXPECT_LT((p.svv - (s(0, 1) - 2.0 * s(0, 0) + s(0, -1)) / (step * step)).norm(), 1e-3);
        EXPECT_LT((p.suv - (s(1, 1) - s(1, -1) - s(-1, 1) + s(-1, -1)) / (4 * step * step)).norm(), 1e-4);
    }
    for (const auto& breaks : {patch->v_breaks()}) {  // C2 across every profile, also where the straight ends begin
        for (std::size_t k = 1; k + 1 < breaks.size(); ++k) {
            const PatchPoint a = patch->at(3.3, breaks[k] - 1e-9), b = patch->at(3.3, breaks[k] + 1e-9);
            EXPECT_LT((a.sv - b.sv).norm() + (a.svv - b.svv).norm() + (a.suv - b.suv).norm(), 1e-6);
        }
    }
    for (const double at : patch->u_breaks()) {
        const PatchPoint a = patch->at(at - 1e-9, 5.0), b = patch->at(at + 1e-9, 5.0);
        EXPECT_LT((a.su - b.su).norm() + (a.suu - b.suu).norm() + (a.suv - b.suv).norm(), 1e-6);
    }
}

/// How far a loft lies beside the elliptic cylinder of half axes 10 and 2.
double off_the_cylinder(const std::vector<Points>& profiles) {
    const auto patch = LoftPatch::make(profiles, 0.0);
    EXPECT_TRUE(patch);
    double worst = 0.0;
    for (double u = 0.0; patch && u < 40.0; u += 0.01) {
        const Eigen::Vector3d p = (*patch)->point(u, 6.7);
        const Eigen::Vector2d gradient(2.0 * p.x() / 100.0, 2.0 * p.y() / 4.0);
        worst = std::max(worst, std::abs(p.x() * p.x() / 100.0 + p.y() * p.y() / 4.0 - 1.0) / gradient.norm());
    }
    return worst;
}

TEST(Loft, ProfilesWithDifferentNumbersAreJoinedFromTheirSharpestPoint) {
    // The same ellipse, sampled differently from different starts: the loft must be the elliptic cylinder, untwisted.
    EXPECT_LT(off_the_cylinder({ellipse(10.0, 2.0, 0.0, 300, 1.0), ellipse(10.0, 2.0, 10.0, 240, 2.0),
                                ellipse(10.0, 2.0, 20.0, 300, 0.3, true)}),
              0.002);
}

TEST(Loft, SoAreProfilesOfOneNumberThatBeginAtDifferentPlaces) {
    EXPECT_LT(off_the_cylinder({ellipse(10.0, 2.0, 0.0, 300, 1.0), ellipse(10.0, 2.0, 10.0, 300, 1.6),
                                ellipse(10.0, 2.0, 20.0, 300, 0.3)}),
              0.002);
}

TEST(Loft, DistanceIsOneLipschitzAndIndependentOfTheWarmStart) {
    std::vector<Points> profiles;
    for (int k = 0; k < 4; ++k)
        profiles.push_back(ellipse(15.0 - k, 1.0 + 0.1 * k, 10.0 * k, 80, 0.3 * k));
    const PatchSurface surface(LoftPatch::make(profiles, 1.0).value());
    core::Rng rng(8);
    std::size_t warm = 0;
    for (int i = 0; i < 5000; ++i) {
        const Eigen::Vector3d p(rng.uniform(-20.0, 20.0), rng.uniform(-8.0, 8.0), rng.uniform(3.0, 27.0));
        const Eigen::Vector3d q =
            p + 0.1 * Eigen::Vector3d(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
        const double dp = surface.nearest(p, warm).distance_mm, dq = surface.nearest(q, warm).distance_mm;
        std::size_t cold = 0;
        EXPECT_NEAR(dq, surface.nearest(q, cold).distance_mm, 1e-12);
        // Inside, where both sides are equally far, the facets decide: the other side may be farther by their chord
        // error.
        EXPECT_LE(std::abs(dp - dq), (p - q).norm() + (dp > 0.0 && dq > 0.0 ? 1e-9 : 0.02));
    }
}

TEST(Loft, Errors) {
    const auto message = [](std::vector<Points> profiles) {
        const auto patch = LoftPatch::make(std::move(profiles), 1.0);
        return patch ? std::string("made") : patch.error().message;
    };
    EXPECT_EQ(message({ellipse(1, 1, 0, 20)}), "a loft needs at least two profiles");
    EXPECT_EQ(message({ellipse(1, 1, 0, 20), ellipse(1, 1, 5, 6)}), "a profile of 6 points; it needs at least 8");
    EXPECT_EQ(message({ellipse(1, 1, 5, 20), ellipse(1, 1, 5, 20)}),
              "two profiles in the same place, at about z = 5.000 mm");
}

/// A real blade: closed, the ball finds it all the way round near the middle, contacts and distance agree.
void expect_scannable(const PatchSurface& surface, double z) {
    EXPECT_TRUE(surface.facets().defects().watertight());
    const auto& patch = surface.patch();
    std::size_t warm = 0;
    for (const double u : surface.u_lines()) {
        double low = patch.v_breaks().front(), high = patch.v_breaks().back();
        for (int i = 0; i < 60; ++i)
            (patch.point(u, 0.5 * (low + high)).z() < z ? low : high) = 0.5 * (low + high);
        const PatchPoint p = patch.at(u, low);
        const Eigen::Vector3d n = p.su.cross(p.sv).normalized();
        const Eigen::Vector3d flat = Eigen::Vector3d(n.x(), n.y(), 0.0).normalized();
        const Contact on = surface.nearest(p.s, warm);
        EXPECT_NEAR(on.distance_mm, 0.0, 1e-9);
        const auto ball = touch_along(surface, p.s + 1.2 * flat, -flat, -3.0, 3.0, 1.0, warm);
        ASSERT_TRUE(ball) << p.s.transpose();
        EXPECT_NEAR(surface.nearest(ball->centre, warm).distance_mm, 1.0, 2e-8);
    }
}

TEST(Loft, HannoverRotorAndStatorLoadDirectly) {
    const std::string folder = "../shared/data/hannover-4ac/";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not here";
    for (const char* file : {"1_Rotor1_Blade.crv", "2_Stator1_Vane.crv"}) {
        auto profiles = read_sections({folder + file}, "auto");
        ASSERT_TRUE(profiles) << profiles.error().text();
        ASSERT_EQ(profiles->size(), 7U);
        const auto patch = LoftPatch::make(*profiles, 1.0);
        ASSERT_TRUE(patch) << patch.error().text();
        const PatchSurface surface(*patch);
        std::size_t warm = 0;
        for (const auto& profile : *profiles) {  // it goes through every point of the file
            for (const auto& p : profile)
                EXPECT_NEAR(surface.nearest(p, warm).distance_mm, 0.0, 1e-9);
        }
        const Box box = surface.box();
        for (const double part : {0.2, 0.5, 0.8})
            expect_scannable(surface, std::lerp(box.low.z(), box.high.z(), part));
    }
}

TEST(Loft, Rotor37LoadsAfterConversion) {
    const std::string file = "../shared/data/rotor37/cffc_rotor37geometry.dat";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not here";
    const auto profiles = parse_sections(test::rotor37_crv(core::read_file(file).value()), "rotor37.crv");
    ASSERT_TRUE(profiles) << profiles.error().text();
    ASSERT_EQ(profiles->size(), 13U);
    for (const auto& profile : *profiles)
        EXPECT_EQ(profile.size(), 198U);
    auto turned = *profiles;
    for (auto& profile : turned) {
        for (auto& p : profile)
            p = {p.z(), p.x(), p.y()};
    }
    const auto patch = LoftPatch::make(turned, 1.0);
    ASSERT_TRUE(patch) << patch.error().text();
    const PatchSurface surface(*patch);
    EXPECT_NEAR(surface.box().high.z(), 252.0, 5.0);  // tip radius 25.2 cm
    for (const double z : {190.0, 215.0, 240.0})
        expect_scannable(surface, z);
}

}  // namespace
}  // namespace cmm::sim
