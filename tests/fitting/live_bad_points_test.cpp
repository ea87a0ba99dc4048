// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.hpp"
#include "fitting/live_spline.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

/// On a circle of 2 mm, 0.1 mm apart, 1 um of noise; `off` of the samples from 60 on.
struct Circle {
    LiveSpline curve{MaterialSide::left};
    core::Rng rng{11};
    std::uint64_t next = 0;

    static Vec2 out(std::uint64_t k) {
        const double angle = 0.05 * static_cast<double>(k);
        return {std::cos(angle), std::sin(angle)};
    }
    void add(double off = 0.0) {
        curve.add(next, (2.0 + off + 1e-3 * rng.normal()) * out(next));
        ++next;
    }
    void add_good(int count) {
        for (int k = 0; k < count; ++k)
            add();
    }
};

TEST(LiveBadPoints, ABadSampleIsInDoubtAtOnceAndTurnsNobodysHead) {
    for (const double bad : {0.05, 0.1, 0.4, -0.05, -0.1, -0.4}) {
        Circle circle;
        circle.add_good(60);
        circle.add(bad);
        const auto newest = circle.curve.newest();
        EXPECT_TRUE(newest.doubtful) << bad;
        EXPECT_NEAR(newest.position.norm(), 2.0, 0.004) << bad;
        EXPECT_GT(newest.normal.dot(Circle::out(60)), 0.9995) << bad;
        EXPECT_NEAR(circle.curve.predict(0.1).centre.norm(), 2.0, 0.006) << bad;
        EXPECT_EQ(circle.curve.suggest_step(0.05, 0.5, 0.001), 0.05) << bad;
    }
}

/// A sample 20 um off may be the beginning of a sharper turn; what is said of the next one leaves room for both.
TEST(LiveBadPoints, TheNextSamplesConvictASmallError) {
    for (const double bad : {0.02, 0.03, 0.05, 0.4, -0.02, -0.03, -0.05, -0.4}) {
        Circle circle;
        circle.add_good(60);
        circle.add(bad);
        const auto next = circle.curve.predict(0.1);
        EXPECT_LT(std::abs(next.centre.norm() - 2.0), 3.0 * next.sigma_mm) << bad;
        circle.add_good(3);
        EXPECT_TRUE(circle.curve.point(3).doubtful) << bad;
        EXPECT_FALSE(circle.curve.newest().doubtful) << bad;
        circle.add_good(5);
        EXPECT_TRUE(circle.curve.point(8).doubtful) << bad;
        EXPECT_NEAR(circle.curve.point(8).position.norm(), 2.0, 0.002) << bad;
        EXPECT_LT(circle.curve.noise_mm(), 0.0014) << bad;
    }
}

TEST(LiveBadPoints, RunsOfUpToThree) {
    for (const double bad : {0.03, 0.1, 0.4, -0.1, -0.4}) {
        for (int run = 1; run <= 3; ++run) {
            Circle circle;
            circle.add_good(60);
            for (int k = 0; k < run; ++k)
                circle.add(bad * (1.0 - 0.2 * k));
            circle.add_good(8);
            for (int k = 0; k < run + 8; ++k) {
                const auto point = circle.curve.point(static_cast<std::size_t>(k));
                EXPECT_EQ(point.doubtful, k >= 8) << bad << " run " << run << " back " << k;
                EXPECT_NEAR(point.position.norm(), 2.0, 0.005) << bad << " run " << run << " back " << k;
            }
        }
    }
}

/// From a straight side on a circle of 0.6 mm in steps of 0.3 mm: the first sample beyond is 75 um off what was
/// expected. Its successors tell that it is good.
TEST(LiveBadPoints, SuccessorsLetASampleInAgain) {
    LiveSpline curve(MaterialSide::left);
    core::Rng rng(2);
    std::uint64_t next = 0;
    for (; next < 60; ++next)
        curve.add(next, {0.3 * static_cast<double>(next), 1e-3 * rng.normal()});
    const Vec2 centre(0.3 * 59, 0.6);
    const auto on_edge = [&](int k) {
        const double angle = 0.5 * k;
        return Vec2(centre + (0.6 + 1e-3 * rng.normal()) * Vec2(std::sin(angle), -std::cos(angle)));
    };
    curve.add(next++, on_edge(1));
    EXPECT_GT((curve.predict(0.3).centre - on_edge(2)).norm(), 0.02) << "nobody could know";
    EXPECT_GT(curve.predict(0.3).sigma_mm, 0.02);
    for (int k = 2; k <= 5; ++k)
        curve.add(next++, on_edge(k));
    for (std::size_t back = 0; back <= 8; ++back)
        EXPECT_FALSE(curve.point(back).doubtful) << back;
    EXPECT_NEAR(curve.newest().curvature, 1.0 / 0.6, 0.1);
    EXPECT_NEAR((curve.point(4).position - centre).norm(), 0.6, 0.003);
}

/// 1.5 % bad samples of 20 to 400 um in runs of up to three, mostly at the edges.
TEST(LiveBadPoints, OnBladesOfThreeFamilies) {
    int bad = 0, found = 0, good = 0, lost = 0, large = 0, large_found = 0;
    double squares = 0.0;
    for (const auto family : families::all_families) {
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            const auto blade = families::make(family, seed);
            families::ScanOptions options;
            options.points = 1200;
            options.seed = seed;
            const auto scan = families::scan(blade, options);
            LiveSpline curve(MaterialSide::left);
            for (std::size_t i = 0; i < scan.points.size(); ++i) {
                curve.add(i, scan.points[i]);
                if (i < 3 * LiveSpline::lag) continue;
                const auto point = curve.point(LiveSpline::lag);
                const double height = std::abs(scan.bad[i - LiveSpline::lag]);
                (height > 0.0 ? bad : good) += 1;
                if (point.doubtful) (height > 0.0 ? found : lost) += 1;
                large += height > 0.04;
                large_found += height > 0.04 && point.doubtful;
                if (height == 0.0) squares += std::pow(blade.distance(point.position) - options.ball_mm, 2);
            }
        }
    }
    EXPECT_GT(bad, 500);
    EXPECT_GT(found, 0.97 * bad);
    EXPECT_GT(large_found, 0.985 * large);
    EXPECT_LT(lost, 0.001 * good);
    EXPECT_LT(std::sqrt(squares / good), 1.2e-3);
}

}  // namespace
}  // namespace cmm::fitting
