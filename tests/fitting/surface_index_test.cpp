// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_index.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/rng.hpp"
#include "support/surfaces.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr double whole_turn = 2 * std::numbers::pi;
constexpr double one_nm = 1e-6;

/// The least distance by brute force: a grid finer than any curvature, each of its twenty best nodes polished by
/// descent.
double nearest_by_force(const Surface& s, const Vec3& p, int nu, int nv) {
    std::vector<std::pair<double, SurfacePlace>> nodes;
    for (int j = 0; j <= nv; ++j)
        for (int i = 0; i < nu; ++i) {
            const SurfacePlace at{s.u().front() + (s.u().back() - s.u().front()) * i / nu,
                                  s.v().front() + (s.v().back() - s.v().front()) * j / nv};
            nodes.push_back({(s.position(at) - p).norm(), at});
        }
    std::partial_sort(nodes.begin(), nodes.begin() + 20, nodes.end(),
                      [](const auto& a, const auto& b) { return a.first < b.first; });
    double least = nodes[0].first;
    for (int k = 0; k < 20; ++k) {
        SurfacePlace at = nodes[static_cast<std::size_t>(k)].second;
        double here = nodes[static_cast<std::size_t>(k)].first;
        double step_u = (s.u().back() - s.u().front()) / nu, step_v = (s.v().back() - s.v().front()) / nv;
        while (step_u > 1e-9) {
            bool better = false;
            for (const auto& [a, b] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, -1}, {1, -1}, {-1, 1}}) {
                const SurfacePlace next{at.u + a * step_u, s.v().inside(at.v + b * step_v)};
                const double d = (s.position(next) - p).norm();
                if (d < here) {
                    here = d;
                    at = next;
                    better = true;
                }
            }
            if (!better) {
                step_u *= 0.5;
                step_v *= 0.5;
            }
        }
        least = std::min(least, here);
    }
    return least;
}

/// u is the share of the perimeter.
Surface blade_surface(const families::TwistedBlade& blade, std::size_t count_u, std::size_t count_v) {
    constexpr int steps = 4000;
    const auto outline = blade.outline(0.5 * blade.height());
    std::vector<double> length{0.0};
    for (int k = 0; k < steps; ++k)
        length.push_back(length.back() + outline.at(4.0 * (k + 0.5) / steps).d1.norm());
    const auto parameter = [&](double u) {
        const double wanted = (u - std::floor(u)) * length.back();
        const auto above = std::upper_bound(length.begin() + 1, length.end() - 1, wanted);
        return 4.0 / steps * (double(above - length.begin()) - 1 + (wanted - *(above - 1)) / (*above - *(above - 1)));
    };
    return spline_of(
        [&](double u, double v) { return blade.at(parameter(u), std::clamp(v, -2.0, blade.height() + 2)).position; }, 1,
        count_u, true, blade.height(), count_v);
}

TEST(SurfaceIndex, DistancesToKnownSurfaces) {
    const Surface cylinder = spline_of([](double u, double v) { return Vec3(5 * std::cos(u), 5 * std::sin(u), v); },
                                       whole_turn, 400, true, 20, 10);
    const SurfaceIndex index(cylinder);
    core::Rng rng(1);
    for (int k = 0; k < 2000; ++k) {
        const double r = rng.uniform(0.5, 12), a = rng.uniform(0, whole_turn), z = rng.uniform(-5, 25);
        const SurfaceFoot foot = index.closest({r * std::cos(a), r * std::sin(a), z});
        const double beyond = std::max({-z, z - 20, 0.0});
        EXPECT_NEAR(std::sqrt(foot.squared), std::hypot(r - 5, beyond), 2e-8);
        EXPECT_NEAR(foot.place.v, std::clamp(z, 0.0, 20.0), 1e-6);
    }
    const SurfaceFoot axis = index.closest({0, 0, 10});
    EXPECT_NEAR(std::sqrt(axis.squared), 5, 1e-6) << "as near everywhere";
    const SurfaceFoot lost = index.closest({std::nan(""), 0, 0});
    EXPECT_TRUE(std::isinf(lost.squared));
    EXPECT_NEAR(std::sqrt(index.closest({1e9, 0, 0}).squared), 1e9 - 5, 1e-3);
}

TEST(SurfaceIndex, FindsTheFootOfPointsOffATorusPatch) {
    const auto on_torus = [](double u, double v) {
        const double r = 8 + 2 * std::cos(v - 1);
        return Vec3(r * std::cos(u), r * std::sin(u), 2 * std::sin(v - 1));
    };
    const Surface torus = spline_of(on_torus, 3.0, 120, false, 2, 80);
    const SurfaceIndex index(torus);
    core::Rng rng(2);
    for (int k = 0; k < 1000; ++k) {
        const SurfacePlace at{rng.uniform(0.01, 2.99), rng.uniform(0.01, 1.99)};
        const double off = rng.uniform(-1.5, 4);
        const SurfaceFoot foot = index.closest(torus.position(at) + off * torus.jet(at).normal());
        EXPECT_NEAR(std::sqrt(foot.squared), std::abs(off), 1e-9);
        EXPECT_NEAR(foot.place.u, at.u, 1e-7);
        EXPECT_NEAR(foot.place.v, at.v, 1e-7);
    }
}

TEST(SurfaceIndex, FarFromTheOriginAsWell) {
    for (const double away : {3e4, 5e5, 3e6}) {
        const Vec3 origin(away, -0.7 * away, 0.4 * away);
        const Surface torus = spline_of(
            [&](double u, double v) -> Vec3 {
                const double r = 8 + 2 * std::cos(v - 1);
                return origin + Vec3(r * std::cos(u), r * std::sin(u), 2 * std::sin(v - 1));
            },
            3.0, 120, false, 2, 80);
        const SurfaceIndex index(torus);
        core::Rng rng(7);
        for (int k = 0; k < 20; ++k) {
            const SurfacePlace at{rng.uniform(0.01, 2.99), rng.uniform(0.01, 1.99)};
            const double off = rng.uniform(-1.5, 4);
            const Vec3 p = torus.position(at) + off * torus.jet(at).normal();
            EXPECT_NEAR(std::sqrt(index.closest(p).squared), std::abs(off), 1e-14 * away + 1e-8) << away;
            EXPECT_NEAR(std::sqrt(index.closest(p, SurfacePlace{1, 1}).squared), std::abs(off), 1e-14 * away + 1e-8);
        }
    }
}

TEST(PatchGroup, IsNeverMoreThanThePatchesSay) {
    const families::TwistedBlade blade(families::Family::fan, 2);
    const Surface s = blade_surface(blade, 60, 12);
    core::Rng rng(8);
    double loosest = 0.0;
    for (int k = 0; k < 200; ++k) {
        PatchGroup group;
        std::vector<PatchBounds> patches;
        for (std::size_t lane = 0; lane < PatchGroup::size; ++lane) {
            const std::size_t i = rng.below(s.u().spans()), j = rng.below(s.v().spans());
            patches.emplace_back(s, PatchDomain{i, j, s.u().low(i), s.u().high(i), s.v().low(j), s.v().high(j)});
            group.set(lane, patches.back());
        }
        const Vec3 p(rng.uniform(-60, 60), rng.uniform(-60, 60), rng.uniform(-10, 10 + blade.height()));
        const auto least = group.least_distances({float(p.x()), float(p.y()), float(p.z())});
        double size = p.cwiseAbs().maxCoeff();
        for (const PatchBounds& patch : patches)
            size = std::max({size, patch.low().cwiseAbs().maxCoeff(), patch.high().cwiseAbs().maxCoeff()});
        for (std::size_t lane = 0; lane < PatchGroup::size; ++lane) {
            const double exact = patches[lane].least_distance(p);
            EXPECT_LT(least[Eigen::Index(lane)], exact + 0x1p-19 * size);
            loosest = std::max(loosest, (exact - least[Eigen::Index(lane)]) / std::max(exact, 1.0));
        }
    }
    EXPECT_LT(loosest, 0.5) << "corners and spheres are left out, not more";
}

TEST(PatchBounds, NearerThanIsWhatTheLeastDistanceSays) {
    const families::TwistedBlade blade(families::Family::turbine, 2);
    const Surface s = blade_surface(blade, 60, 12);
    core::Rng rng(9);
    for (int k = 0; k < 2000; ++k) {
        const std::size_t i = rng.below(s.u().spans()), j = rng.below(s.v().spans());
        const PatchBounds patch(s, {i, j, s.u().low(i), s.u().high(i), s.v().low(j), s.v().high(j)});
        const Vec3 p(rng.uniform(-60, 60), rng.uniform(-60, 60), rng.uniform(-10, 10 + blade.height()));
        const double least = patch.least_distance(p);
        EXPECT_TRUE(patch.nearer_than(least + 1e-9, p));
        EXPECT_FALSE(patch.nearer_than(least - 1e-9, p));
    }
    const PatchBounds patch(s, {3, 3, s.u().low(3), s.u().high(3), s.v().low(3), s.v().high(3)});
    const Vec3 on = s.position({s.u().low(3), s.v().low(3)});
    EXPECT_TRUE(patch.nearer_than(1e-9, on));
    EXPECT_FALSE(patch.nearer_than(-10.0, on)) << "nothing is nearer than less than nothing";
}

TEST(SurfaceIndex, NothingIsNearerOnAnEllipsoid) {
    const Surface s = spline_of(
        [](double u, double v) {
            const double b = v - 1.2;
            return Vec3(6 * std::cos(u) * std::cos(b), 2 * std::sin(u) * std::cos(b), 3 * std::sin(b));
        },
        whole_turn, 60, true, 2.4, 24);
    const SurfaceIndex index(s);
    core::Rng rng(3);
    for (int k = 0; k < 60; ++k) {
        const Vec3 p(rng.uniform(-8, 8), rng.uniform(-4, 4), rng.uniform(-5, 5));
        EXPECT_NEAR(std::sqrt(index.closest(p).squared), nearest_by_force(s, p, 240, 96), one_nm);
    }
}

TEST(SurfaceIndex, NothingIsNearerOnBladesWhateverTheHint) {
    for (const auto family : families::all_families) {
        const families::TwistedBlade blade(family, 3);
        const Surface s = blade_surface(blade, 300, 12);
        const SurfaceIndex index(s);
        core::Rng rng(4);
        for (int k = 0; k < 25; ++k) {
            const SurfaceJet jet = s.jet({rng.uniform(0, 1), rng.uniform(0, blade.height())});
            const Vec3 p = jet.position + rng.uniform(-3, 3) * jet.normal();
            const double cold = std::sqrt(index.closest(p).squared);
            EXPECT_NEAR(cold, nearest_by_force(s, p, 1000, 40), one_nm) << blade.name();
            for (int h = 0; h < 4; ++h) {
                const SurfacePlace hint{rng.uniform(0, 1), rng.uniform(0, blade.height())};
                EXPECT_NEAR(std::sqrt(index.closest(p, hint).squared), cold, one_nm);
            }
        }
    }
}

TEST(SurfaceIndex, PointsOnItAreOnItWhereverNewtonEnds) {
    for (const auto family : families::all_families) {
        const families::TwistedBlade blade(family, 3);
        const Surface s = blade_surface(blade, 400, 16);
        const SurfaceIndex index(s);
        core::Rng rng(8);
        double farthest = 0.0, farthest_along = 0.0;
        for (int k = 0; k < 5000; ++k) {
            const SurfacePlace at{rng.uniform(0, 1), rng.uniform(0, blade.height())};
            const double beside = std::pow(10.0, rng.uniform(-6, -2));
            const SurfacePlace hint{at.u + beside * rng.uniform(-1, 1), at.v + 50 * beside * rng.uniform(-1, 1)};
            farthest = std::max(farthest, std::sqrt(index.closest(s.position(at), hint).squared));
            SurfaceSpans near;
            const auto foot = newton_foot(s, s.position(at), hint, near);
            if (foot) farthest_along = std::max(farthest_along, std::sqrt(foot->squared));
        }
        EXPECT_LT(farthest, one_nm) << blade.name();
        EXPECT_LT(farthest_along, one_nm) << blade.name();
    }
}

TEST(SurfaceIndex, ManyPointsInAnyOrder) {
    const families::TwistedBlade blade(families::Family::compressor, 5);
    const Surface s = blade_surface(blade, 400, 16);
    const SurfaceIndex index(s);
    core::Rng rng(5);
    std::vector<Vec3> points;
    for (int k = 0; k < 3000; ++k) {
        const SurfaceJet jet = s.jet({rng.uniform(0, 1), rng.uniform(0, blade.height())});
        points.push_back(jet.position + rng.uniform(-1, 3) * jet.normal());
    }
    std::vector<SurfaceFoot> feet(points.size());
    SearchCost cost;
    index.closest(points, feet, &cost);
    EXPECT_GT(cost.steps, points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
        EXPECT_NEAR(std::sqrt(feet[k].squared), std::sqrt(index.closest(points[k]).squared), one_nm);
        EXPECT_NEAR((s.position(feet[k].place) - points[k]).squaredNorm(), feet[k].squared, 1e-9);
    }
}

TEST(SurfaceIndex, NewtonFromAnywhereSaysWhenItFails) {
    const families::TwistedBlade blade(families::Family::turbine, 1);
    const Surface s = blade_surface(blade, 400, 16);
    core::Rng rng(6);
    SearchCost warm, cold;
    SurfaceSpans near;
    for (int k = 0; k < 500; ++k) {
        const SurfacePlace at{rng.uniform(0, 1), rng.uniform(1, blade.height() - 1)};
        const Vec3 p = s.position(at) + 1e-3 * s.jet(at).normal();
        const auto foot = newton_foot(s, p, {at.u + 1e-4, at.v + 0.01}, near, &warm);
        ASSERT_TRUE(foot);
        EXPECT_NEAR(foot->squared, 1e-6, 1e-12);
        const auto far = newton_foot(s, p, {rng.uniform(0, 1), rng.uniform(0, blade.height())}, near, &cold);
        EXPECT_TRUE(!far || far->squared > 0.99e-6);
    }
    EXPECT_LT(warm.steps, 4 * 500U);
    EXPECT_EQ(warm.failures, 0U);
    EXPECT_GT(cold.steps, 2 * warm.steps);
}

}  // namespace
}  // namespace cmm::fitting
