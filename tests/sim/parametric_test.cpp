// SPDX-License-Identifier: Apache-2.0
#include "sim/parametric.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "core/rng.hpp"
#include "tests/sim/test_blades.hpp"

namespace cmm::sim {
namespace {

/// The section as the document states it: the union of circles on the camber line. In the chord frame its boundary's
/// distance is the least of |P - m(t)| - rho(t), written here independently of the patch.
double section_distance(const BladeNumbers& n, double z, const Eigen::Vector2d& p) {
    const double s = (z - n.z_root_mm) / (n.z_tip_mm - n.z_root_mm);
    const double c = std::lerp(n.chord_root_mm, n.chord_tip_mm, s),
                 T = std::lerp(n.thickness_root_mm, n.thickness_tip_mm, s);
    const double g = std::lerp(n.stagger_root_rad, n.stagger_tip_rad, s);
    const double r1 = n.le_radius_mm * c / n.chord_root_mm, r2 = n.te_radius_mm * c / n.chord_root_mm;
    const Eigen::Vector2d moved =
        p - (z - n.z_root_mm) * Eigen::Vector2d(std::tan(n.lean_x_rad), std::tan(n.lean_y_rad));
    const Eigen::Vector2d q(std::cos(g) * moved.x() + std::sin(g) * moved.y(),
                            -std::sin(g) * moved.x() + std::cos(g) * moved.y());
    const double k = c - r1 - r2, th = n.camber_rad, R = th == 0.0 ? 0.0 : k / (2.0 * std::sin(th / 2.0));
    const auto gap = [&](double t) {
        const double a = (t - 0.5) * th;
        const Eigen::Vector2d m = th == 0.0 ? Eigen::Vector2d((t - 0.5) * k, 0.0)
                                            : Eigen::Vector2d(R * std::sin(a), R * (std::cos(a) - std::cos(th / 2.0)));
        const double f = 0.5 * 4.0 * t * (1.0 - t) + 0.5 * 6.75 * t * (1.0 - t) * (1.0 - t);
        return (q - m).norm() - (r1 * (1.0 - t) + r2 * t + (T / 2.0 - (r1 + r2) / 2.0) * f);
    };
    double best = 0.0;
    for (int i = 1; i <= 4000; ++i) {
        if (gap(i / 4000.0) < gap(best)) best = i / 4000.0;
    }
    double low = std::max(0.0, best - 1.0 / 4000.0), high = std::min(1.0, best + 1.0 / 4000.0);
    for (int i = 0; i < 80; ++i) {
        const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
        (gap(a) < gap(b) ? high : low) = gap(a) < gap(b) ? b : a;
    }
    return gap(0.5 * (low + high));
}

TEST(BladePatch, LiesOnTheEnvelopeOfTheDocument) {
    for (const BladeNumbers& n : {test::twisted_blade(), test::straight_blade()}) {
        const auto patch = BladePatch::make(n, 1.0).value();
        const double period = patch->u_breaks().back();
        for (int i = 0; i < 400; ++i) {
            const double u = period * i / 400.0, z = -0.9 + 0.15 * i;
            const Eigen::Vector3d p = patch->point(u, z);
            EXPECT_NEAR(section_distance(n, z, p.head<2>()), 0.0, 1e-9) << u;
            EXPECT_NEAR(p.z(), z, 1e-12);
        }
    }
}

TEST(BladePatch, EdgesAreTrueArcs) {
    const BladeNumbers n = test::twisted_blade();
    const auto patch = BladePatch::make(n, 1.0).value();
    const auto& u = patch->u_breaks();
    for (const auto& [from, to, root_radius] :
         {std::tuple{u[1], u[2], n.le_radius_mm}, std::tuple{u[3], u[4], n.te_radius_mm}}) {
        for (const double z : {0.0, 17.0, 60.0}) {
            const double scale = std::lerp(n.chord_root_mm, n.chord_tip_mm, z / 60.0) / n.chord_root_mm;
            const Eigen::Vector3d a = patch->point(from, z), b = patch->point(0.5 * (from + to), z);
            const Eigen::Vector3d inward = (0.5 * (a + patch->point(std::nextafter(to, from), z)) - b).normalized();
            const Eigen::Vector3d centre = b + root_radius * scale * inward;
            for (double w = 0.0; w < 1.0; w += 0.05) {
                EXPECT_NEAR((patch->point(std::lerp(from, to, w), z) - centre).norm(), root_radius * scale, 1e-9);
            }
        }
    }
}

TEST(BladePatch, DerivativesAgreeWithDifferences) {
    Warp warp;
    warp.twist_rad = 0.02;
    warp.z_high_mm = 60.0;
    warp.centre_mm = {1.0, -2.0};
    warp.shift_mm = {0.1, 0.2, 0.3};
    const auto patch = BladePatch::make(test::twisted_blade(), 1.0, warp).value();
    const double step = 1e-4, period = patch->u_breaks().back();
    for (const double u : {0.1, 0.31, 0.52, 0.77, 0.9, 0.9995}) {
        const double at = u * period, z = 60.0 * u;
        const PatchPoint p = patch->at(at, z);
        const auto s = [&](double i, double j) { return patch->point(at + i * step, z + j * step); };
        EXPECT_LT((p.s - s(0, 0)).norm(), 1e-12);
        EXPECT_LT((p.su - (s(1, 0) - s(-1, 0)) / (2 * step)).norm(), 1e-6);
        EXPECT_LT((p.sv - (s(0, 1) - s(0, -1)) / (2 * step)).norm(), 1e-6);
        EXPECT_LT((p.suu - (s(1, 0) - 2.0 * s(0, 0) + s(-1, 0)) / (step * step)).norm(), 1e-4);
        EXPECT_LT((p.svv - (s(0, 1) - 2.0 * s(0, 0) + s(0, -1)) / (step * step)).norm(), 1e-4);
        EXPECT_LT((p.suv - (s(1, 1) - s(1, -1) - s(-1, 1) + s(-1, -1)) / (4 * step * step)).norm(), 1e-4);
    }
}

TEST(PatchSurface, PrismaticBladeHasThePlaneDistance) {
    const BladeNumbers n = test::straight_blade();
    const PatchSurface surface(BladePatch::make(n, 20.0).value());
    core::Rng rng(2);
    std::size_t warm = 0;
    for (int i = 0; i < 1000; ++i) {
        const Eigen::Vector3d p(rng.uniform(-25.0, 25.0), rng.uniform(-6.0, 6.0), rng.uniform(20.0, 40.0));
        EXPECT_NEAR(surface.nearest(p, warm).distance_mm, section_distance(n, p.z(), p.head<2>()), 1e-9);
    }
}

TEST(PatchSurface, TwistedBladeHasTheTrueSpatialDistance) {
    const auto patch = BladePatch::make(test::twisted_blade(), 1.0).value();
    const PatchSurface surface(patch);
    core::Rng rng(4);
    std::size_t warm = 0;
    const double period = patch->u_breaks().back();
    for (int i = 0; i < 60; ++i) {
        const Eigen::Vector3d on = patch->point(rng.uniform(0.0, period), rng.uniform(10.0, 50.0));
        const Eigen::Vector3d p =
            on + Eigen::Vector3d(rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0), rng.uniform(-2.0, 2.0));
        // Coarse to fine search over the whole patch around the best place so far.
        double best = std::numeric_limits<double>::max(), bu = 0.0, bv = p.z(), wu = period / 2.0, wv = 4.0;
        for (int level = 0; level < 40; ++level) {
            const double cu = bu, cv = bv;
            const int around = level == 0 ? 400 : 15;
            for (int a = -around; a <= around; ++a) {
                for (int b = -30; b <= 30; b += level == 0 ? 1 : 3) {
                    const double u = cu + wu * a / around, v = std::clamp(cv + wv * b / 30.0, -1.0, 61.0);
                    const double d = (patch->point(u, v) - p).norm();
                    if (d < best) best = d, bu = u, bv = v;
                }
            }
            wu *= level == 0 ? 0.02 : 0.6;
            wv *= level == 0 ? 0.2 : 0.6;
        }
        const Contact contact = surface.nearest(p, warm);
        EXPECT_NEAR(std::abs(contact.distance_mm), best, 1e-8);
        EXPECT_LT((contact.point + contact.distance_mm * contact.normal - p).norm(), 1e-7);
        EXPECT_EQ(contact.distance_mm < 0.0, section_distance(patch->numbers(), p.z(), p.head<2>()) < 0.0);
    }
}

TEST(PatchSurface, IsOneLipschitzAlsoAtItsEnds) {
    const PatchSurface surface(BladePatch::make(test::twisted_blade(), 1.0).value());
    core::Rng rng(9);
    std::size_t warm = 0;
    for (int i = 0; i < 20000; ++i) {
        const Eigen::Vector3d p(rng.uniform(-25.0, 25.0), rng.uniform(-15.0, 15.0), rng.uniform(-5.0, 65.0));
        const Eigen::Vector3d q =
            p + 0.2 * Eigen::Vector3d(rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0), rng.uniform(-1.0, 1.0));
        const double dp = surface.nearest(p, warm).distance_mm, dq = surface.nearest(q, warm).distance_mm;
        // The flat ends are facets on the chords of the rim: they may differ from the tube by the chord error.
        EXPECT_LE(std::abs(dp - dq), (p - q).norm() + 0.010) << p.transpose() << " / " << q.transpose();
    }
    EXPECT_GT(surface.nearest({0.0, 0.0, 70.0}, warm).distance_mm, 8.9);
}

TEST(BladePatch, RefusesNumbersThatGiveNoSection) {
    auto with = [](auto change) {
        BladeNumbers n = test::twisted_blade();
        change(n);
        const auto patch = BladePatch::make(n, 1.0);
        return patch ? std::string() : patch.error().message;
    };
    EXPECT_EQ(with([](BladeNumbers&) {}), "");
    EXPECT_NE(with([](BladeNumbers& n) { n.z_tip_mm = n.z_root_mm; }).find("z_tip_mm must be above"),
              std::string::npos);
    EXPECT_NE(with([](BladeNumbers& n) { n.te_radius_mm = 0.0; }).find("te_radius_mm must be above 0"),
              std::string::npos);
    EXPECT_NE(with([](BladeNumbers& n) { n.chord_tip_mm = -1.0; }).find("chord is too short"), std::string::npos);
    EXPECT_NE(with([](BladeNumbers& n) { n.thickness_root_mm = 30.0; }).find("grows too fast"), std::string::npos);
    EXPECT_NE(with([](BladeNumbers& n) { n.thickness_root_mm = -3.0; }).find("no thickness"), std::string::npos);
}

}  // namespace
}  // namespace cmm::sim
