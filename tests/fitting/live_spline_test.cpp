// SPDX-License-Identifier: Apache-2.0
#include "fitting/live_spline.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "core/rng.hpp"
#include "support/airfoil.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

TEST(LiveSpline, KnowsTheFrameAndCurvatureOfACircleEitherWay) {
    for (const double sense : {1.0, -1.0}) {
        LiveSpline curve(sense > 0 ? MaterialSide::left : MaterialSide::right);
        core::Rng rng(3);
        Vec2 last = Vec2::Zero();
        for (std::uint64_t k = 0; k < 40; ++k) {
            const double a = sense * 0.1 * static_cast<double>(k) / 1.2;
            last = (1.2 + 0.001 * rng.normal()) * Vec2(std::cos(a), std::sin(a));
            curve.add(k, last);
        }
        const auto newest = curve.newest();
        ASSERT_TRUE(newest.valid);
        EXPECT_FALSE(newest.doubtful);
        EXPECT_EQ(newest.sequence, 39U);
        EXPECT_NEAR(newest.curvature, 1.0 / 1.2, 0.05);
        EXPECT_GT(newest.normal.dot(last.normalized()), 0.9995);
        EXPECT_NEAR(newest.position.norm(), 1.2, 0.0025);
        EXPECT_NEAR(curve.point(LiveSpline::lag).position.norm(), 1.2, 0.0012);
        EXPECT_NEAR(curve.point(LiveSpline::lag).curvature, 1.0 / 1.2, 0.03);
        EXPECT_FALSE(curve.point(LiveSpline::lag + 1).valid);
        EXPECT_NEAR(curve.turned_rad(), 0.1 * 38.5 / 1.2, 0.05);
        EXPECT_NEAR(curve.length_mm(), 0.1 * 39, 0.02);
        EXPECT_FALSE(curve.closed());
    }
}

/// Root mean square distances from the truth, um.
struct Accuracy {
    double newest = 0.0, lagging = 0.0, prediction = 0.0, noise = 0.0;
};

/// Ball centres round an airfoil of 60 mm chord, some scans from random starts.
Accuracy accuracy(std::size_t points, double sigma_mm) {
    static const airfoil::Airfoil truth(1.0);
    Accuracy out;
    double count = 0.0;
    constexpr std::uint64_t scans = 6;
    for (std::uint64_t seed = 1; seed <= scans; ++seed) {
        const auto scan = truth.scan(points, airfoil::Airfoil::Spacing::edges, sigma_mm, seed);
        LiveSpline curve(MaterialSide::left);
        std::size_t near = 0;
        for (std::size_t i = 0; i < scan.size(); ++i) {
            const auto expected = curve.predict(i > 0 ? (scan[i] - scan[i - 1]).norm() : 0.0);
            curve.add(i, scan[i]);
            if (i < 2 * LiveSpline::lag) continue;
            out.newest += std::pow(truth.distance(curve.newest().position, near), 2);
            out.lagging += std::pow(truth.distance(curve.point(LiveSpline::lag).position, near), 2);
            out.prediction += std::pow((scan[i] - expected.centre).dot(expected.normal), 2);
            ++count;
        }
        out.noise += curve.noise_mm() / static_cast<double>(scans);
    }
    for (double* value : {&out.newest, &out.lagging, &out.prediction})
        *value = 1e3 * std::sqrt(*value / count);
    out.noise *= 1e3;
    return out;
}

TEST(LiveSpline, IsNearerToAnAirfoilThanItsPoints) {
    const auto one = accuracy(1000, 1e-3);
    EXPECT_LT(one.newest, 0.8);
    EXPECT_LT(one.lagging, 0.4);
    EXPECT_LT(one.prediction, 2.0);
    EXPECT_NEAR(one.noise, 1.0, 0.1);
    const auto three = accuracy(1000, 3e-3);
    EXPECT_LT(three.newest, 2.4);
    EXPECT_LT(three.lagging, 1.2);
    EXPECT_NEAR(three.noise, 3.0, 0.3);
    const auto none = accuracy(1000, 0.0);
    EXPECT_LT(none.newest, 0.05);
    EXPECT_LT(none.lagging, 0.04);
    EXPECT_LT(none.prediction, 0.6);
    const auto sparse = accuracy(400, 1e-3);
    EXPECT_LT(sparse.lagging, 0.55);
    const auto dense = accuracy(2000, 1e-3);
    EXPECT_LT(dense.newest, 0.65);
    EXPECT_LT(dense.lagging, 0.33);
}

/// The way an adaptive scan goes round an unknown blade: predict, touch what is there, add.
TEST(LiveSpline, LeadsRoundABladeEitherWay) {
    for (const double ball : {0.5, 1.0, 2.0}) {
        const auto centres = truth::ball_centres(truth::envelope_blade({45, 3, 25, 40, 0.25, 0.15}), ball);
        const std::size_t n = centres.points.size();
        for (const bool clockwise : {false, true}) {
            LiveSpline curve(clockwise ? MaterialSide::right : MaterialSide::left);
            core::Rng rng(8);
            std::size_t at = 6000;  // in the middle of a side
            std::uint64_t sequence = 0;
            double worst = 0.0;
            const auto touch = [&](const Vec2& aim) {
                std::size_t best = at;
                for (std::size_t k = 0; k < 2000; ++k) {
                    const std::size_t i = (at + n + (clockwise ? -k : k)) % n;
                    if ((centres.points[i] - aim).squaredNorm() < (centres.points[best] - aim).squaredNorm()) best = i;
                }
                at = best;
                worst = std::max(worst, (centres.points[at] - aim).norm());
                curve.add(++sequence, centres.points[at] + 0.001 * rng.normal() * centres.normals[at]);
            };
            for (int k = 0; k < 4; ++k)
                touch(centres.points[(at + n + (clockwise ? -30 : 30)) % n]);
            worst = 0.0;
            for (int steps = 0; steps < 4000 && !curve.closed(); ++steps) {
                const auto next = curve.predict(curve.suggest_step(0.05, 0.4, 0.002));
                ASSERT_TRUE(next.valid);
                EXPECT_GT(next.normal.dot(centres.normals[at]), 0.7) << "outward";
                touch(next.centre);
            }
            EXPECT_TRUE(curve.closed()) << ball;
            // A step of 0.4 mm straight on where the TE begins misses by its sagitta; the next, careful one by little
            // more.
            EXPECT_LT(worst, 0.4 * 0.4 / 2.0 / (ball + 0.15) + 0.07) << ball;
            EXPECT_NEAR(curve.length_mm(), centres.perimeter(), 2.5);
            EXPECT_NEAR(curve.turned_rad(), 2.0 * pi, 0.3);
        }
    }
}

TEST(LiveSpline, StepFollowsTheChordError) {
    LiveSpline curve(MaterialSide::left);
    EXPECT_DOUBLE_EQ(curve.suggest_step(0.05, 0.5, 0.001), 0.05) << "nothing known: careful";
    for (std::uint64_t k = 0; k < 20; ++k)
        curve.add(k, {0.2 * static_cast<double>(k), 0.0});
    EXPECT_DOUBLE_EQ(curve.suggest_step(0.05, 0.5, 0.001), 0.5);
    LiveSpline round(MaterialSide::left);
    for (std::uint64_t k = 0; k < 20; ++k)
        round.add(k, {std::cos(0.05 * static_cast<double>(k)), std::sin(0.05 * static_cast<double>(k))});
    EXPECT_NEAR(round.suggest_step(0.01, 0.5, 0.001), std::sqrt(0.008), 0.003);
    EXPECT_DOUBLE_EQ(round.suggest_step(0.2, 0.5, 0.001), 0.2);
}

TEST(LiveSpline, ClosesWhenTheStartIsPassedAndNotBefore) {
    const airfoil::Airfoil truth(1.0);
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const auto scan = truth.scan(600, airfoil::Airfoil::Spacing::edges, 1e-3, seed);
        LiveSpline curve(MaterialSide::left);
        for (std::size_t i = 0; i < scan.size(); ++i)
            curve.add(i, scan[i]);
        EXPECT_FALSE(curve.closed()) << "the first point is not yet passed";
        std::size_t beyond = 0;
        for (; beyond < 10 && !curve.closed(); ++beyond)
            curve.add(scan.size() + beyond, scan[beyond]);
        EXPECT_TRUE(curve.closed()) << seed;
        EXPECT_LE(beyond, 4U) << seed;
    }
}

TEST(LiveSpline, SideFromTheFirstTouch) {
    EXPECT_EQ(material_side({1, 0}, {0, 1}), MaterialSide::left);
    EXPECT_EQ(material_side({-1, 0}, {0, 1}), MaterialSide::right);
}

}  // namespace
}  // namespace cmm::fitting
