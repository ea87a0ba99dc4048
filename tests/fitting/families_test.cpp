// SPDX-License-Identifier: Apache-2.0
/// The truth itself: derivatives, joins, foot points and scans of the three families, by definition and by brute force.
#include "support/families.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting::families {
namespace {

template <class Check>
void for_blades(std::uint64_t seeds, const Check& check) {
    for (const Family family : all_families)
        for (std::uint64_t seed = 1; seed <= seeds; ++seed)
            check(make(family, seed));
}

TEST(Families, DerivativesAreThoseOfThePosition) {
    for_blades(10, [](const Blade& blade) {
        core::Rng rng(3);
        for (int k = 0; k < 60; ++k) {
            const double h = 1e-5, t = std::floor(rng.uniform(0, 4)) + rng.uniform(0.001, 0.999);
            const auto a = blade.at(t - h), b = blade.at(t), c = blade.at(t + h);
            EXPECT_LT(((c.position - a.position) / (2 * h) - b.d1).norm(), 1e-6 * (1 + b.d1.norm())) << blade.name();
            EXPECT_LT(((c.d1 - a.d1) / (2 * h) - b.d2).norm(), 1e-5 * (1 + b.d2.norm())) << blade.name() << " " << t;
        }
    });
}

TEST(Families, PartsJoinWithOneTangentAndTurnOnce) {
    for_blades(200, [](const Blade& blade) {
        for (int part = 0; part < 4; ++part) {
            const auto before = blade.at(part + 1 - 1e-13), after = blade.at((part + 1) % 4);
            EXPECT_LT((before.position - after.position).norm(), 1e-9) << blade.name() << " " << part;
            EXPECT_LT((before.normal() - after.normal()).norm(), 1e-9) << blade.name() << " " << part;
        }
        double turned = 0, concave = 0, area = 0, thickest = 0;
        auto last = blade.at(0);
        for (int k = 1; k <= 4000; ++k) {
            const auto jet = blade.at(k % 4000 * 1e-3);
            const Vec2 a = last.normal(), b = jet.normal();
            turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
            area += 0.5 * (last.position.x() * jet.position.y() - last.position.y() * jet.position.x());
            concave = std::min(concave, jet.curvature());
            last = jet;
        }
        for (double w = 0.05; w < 1; w += 0.05)
            thickest = std::max(thickest, std::abs((blade.at(1 + w).position - blade.at(3.999 - w).position).norm()));
        EXPECT_NEAR(turned, 2 * std::numbers::pi, 1e-6) << blade.name();
        EXPECT_GT(area, 0) << blade.name() << ": counter-clockwise";
        EXPECT_GT(concave, -1 / 4.0) << blade.name() << ": a ball of 1 mm touches everywhere";
        EXPECT_NEAR(thickest, blade.shape().thickness, 0.3 * blade.shape().thickness) << blade.name();
    });
}

TEST(Families, TheTurbineTurnsMuchAndItsEndsAreCircles) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
        const Blade blade = make(Family::turbine, seed);
        const double turning =
            std::numbers::pi - std::acos(std::clamp(blade.le().inward.dot(blade.te().inward), -1.0, 1.0));
        EXPECT_GT(turning, 85 * std::numbers::pi / 180) << blade.name();
        EXPECT_LT(turning, 115 * std::numbers::pi / 180) << blade.name();
        for (int k = 0; k < 10; ++k) {
            const double w = 0.1 * k;
            EXPECT_NEAR((blade.at(w).position - blade.le().centre).norm(), blade.le().across, 1e-12);
            EXPECT_NEAR(blade.at(2 + w).curvature(), 1 / blade.te().nose_radius(), 1e-9);
        }
    }
}

TEST(Families, FootPointsAreTheNearest) {
    for_blades(6, [](const Blade& blade) {
        core::Rng rng(5);
        for (int k = 0; k < 40; ++k) {
            const double t = rng.uniform(0, 4), off = rng.uniform(-0.05, 1.5);
            const Vec2 p = blade.at(t).position + off * blade.at(t).normal();
            const Foot foot = blade.closest(p);
            EXPECT_NEAR(foot.distance, off, 1e-10) << blade.name() << " " << t;
            double nearest = std::numeric_limits<double>::infinity();
            for (int i = 0; i < 20000; ++i)
                nearest = std::min(nearest, (blade.at(i * 2e-4).position - p).norm());
            EXPECT_LE(std::abs(foot.distance), nearest + 1e-12);
            EXPECT_NEAR(std::abs(foot.distance), nearest, 0.03) << "steps of up to 0.04 mm";
        }
    });
}

TEST(Families, ScansHoldWhatWasAsked) {
    for_blades(5, [](const Blade& blade) {
        ScanOptions options;
        options.seed = 17;
        options.longest_run = 5;
        options.dirt = 2;
        const BladeScan all = scan(blade, options);
        ASSERT_EQ(all.points.size(), 600U);
        std::array<int, 4> on{};
        std::size_t bad = 0;
        double squares = 0;
        for (std::size_t i = 0; i < 600; ++i) {
            ++on[static_cast<std::size_t>(Blade::part_of(all.t[i]))];
            bad += all.bad[i] != 0;
            const double off = blade.distance(all.points[i]) - options.ball_mm - all.bad[i] - all.dirt[i];
            squares += off * off;
        }
        EXPECT_EQ(on[0], 72);
        EXPECT_EQ(on[2], 72);
        EXPECT_EQ(bad, 9U);
        EXPECT_NEAR(std::sqrt(squares / 600), 1e-3, 1e-4);
        options.sigma_mm = 0;
        options.bad_share = 0;
        options.dirt = 0;
        options.clockwise = true;
        options.overlap = 0.05;
        const BladeScan clean = scan(blade, options);
        ASSERT_EQ(clean.points.size(), 630U);
        for (std::size_t i = 0; i < clean.points.size(); ++i)
            EXPECT_NEAR(blade.distance(clean.points[i]), options.ball_mm, 1e-10);
    });
}

}  // namespace
}  // namespace cmm::fitting::families
