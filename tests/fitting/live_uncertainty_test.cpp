// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/live_spline.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

/// An ellipse of ball centres: smooth everywhere, radius of curvature from 3.2 to 50 mm.
struct Ellipse {
    static constexpr double a = 20.0, b = 8.0, perimeter = 92.1;

    static Vec2 at(double t) { return {a * std::cos(t), b * std::sin(t)}; }
    static Vec2 slope(double t) { return {-a * std::sin(t), b * std::cos(t)}; }
    static Vec2 normal(double t) { return right_normal(slope(t)).normalized(); }
    static double distance(const Vec2& p) {
        double t = std::atan2(p.y() / b, p.x() / a);
        for (int step = 0; step < 20; ++step) {
            const Vec2 off = p - at(t);
            t += off.dot(slope(t)) / (slope(t).squaredNorm() + off.dot(at(t)));
        }
        return (p - at(t)).dot(normal(t));
    }
};

/// Errors over their stated standard deviations.
struct Spread {
    double square = 0.0, inside = 0.0, count = 0.0;

    void add(double error, double sigma) {
        const double z = error / sigma;
        square += z * z;
        inside += std::abs(z) < 1.96 ? 1.0 : 0.0;
        ++count;
    }
    double rms() const { return std::sqrt(square / count); }
    double share() const { return inside / count; }
};

struct Spreads {
    Spread prediction, newest, lagging;
};

Spreads scan_ellipse(double sigma_mm, int points) {
    Spreads out;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        core::Rng rng(seed);
        LiveSpline curve(MaterialSide::left);
        Vec2 last = Vec2::Zero();
        double t = 0.5 * static_cast<double>(seed);
        for (int i = 0; i < points; ++i) {
            const Vec2 sample = Ellipse::at(t) + sigma_mm * rng.normal() * Ellipse::normal(t);
            t += Ellipse::perimeter / points / Ellipse::slope(t).norm();
            const bool settled = i > 40;
            if (settled) {
                const auto expected = curve.predict((sample - last).norm());
                out.prediction.add((sample - expected.centre).dot(expected.normal), expected.sigma_mm);
            }
            curve.add(static_cast<std::uint64_t>(i), sample);
            last = sample;
            if (!settled) continue;
            const auto newest = curve.newest(), lagging = curve.point(LiveSpline::lag);
            out.newest.add(Ellipse::distance(newest.position), newest.sigma_mm);
            out.lagging.add(Ellipse::distance(lagging.position), lagging.sigma_mm);
        }
    }
    return out;
}

/// The stated spread holds jumps of the curvature that a smooth curve does not have: it is a little too wide.
TEST(LiveUncertainty, ErrorsHaveTheStatedSpreadOnASmoothCurve) {
    Spread prediction, newest, lagging;
    const auto join = [](Spread& all, const Spread& one) {
        all.square += one.square;
        all.inside += one.inside;
        all.count += one.count;
    };
    for (const double sigma_mm : {0.5e-3, 1e-3, 2e-3, 3e-3}) {
        for (const int points : {300, 800, 2500}) {
            const auto scan = scan_ellipse(sigma_mm, points);
            EXPECT_GT(scan.prediction.rms(), 0.7) << sigma_mm << " " << points;
            EXPECT_LT(scan.prediction.rms(), 1.15) << sigma_mm << " " << points;
            EXPECT_LT(scan.newest.rms(), 1.25) << sigma_mm << " " << points;
            EXPECT_LT(scan.lagging.rms(), 1.25) << sigma_mm << " " << points;
            join(prediction, scan.prediction);
            join(newest, scan.newest);
            join(lagging, scan.lagging);
        }
    }
    EXPECT_NEAR(prediction.rms(), 0.95, 0.06);
    EXPECT_NEAR(prediction.share(), 0.96, 0.015);
    EXPECT_NEAR(newest.rms(), 1.03, 0.08);
    EXPECT_NEAR(newest.share(), 0.95, 0.02);
    EXPECT_NEAR(lagging.rms(), 1.0, 0.1);
    EXPECT_NEAR(lagging.share(), 0.95, 0.02);
}

/// Blades with edges, whose curvature jumps where the sides begin, and no bad points.
TEST(LiveUncertainty, PredictionsHoldOnBladesWithEdges) {
    for (const auto family : families::all_families) {
        Spread prediction;
        for (std::uint64_t seed = 1; seed <= 10; ++seed) {
            const auto blade = families::make(family, seed);
            families::ScanOptions options;
            options.points = 1200;
            options.bad_share = 0.0;
            options.seed = seed;
            const auto scan = families::scan(blade, options);
            LiveSpline curve(MaterialSide::left);
            for (std::size_t i = 0; i < scan.points.size(); ++i) {
                if (i > 40) {
                    const auto expected = curve.predict((scan.points[i] - scan.points[i - 1]).norm());
                    prediction.add((scan.points[i] - expected.centre).dot(expected.normal), expected.sigma_mm);
                }
                curve.add(i, scan.points[i]);
            }
        }
        EXPECT_NEAR(prediction.rms(), 0.95, 0.15) << to_string(family);
        EXPECT_NEAR(prediction.share(), 0.96, 0.02) << to_string(family);
    }
}

TEST(LiveUncertainty, GrowsWithTheStepAndWithTheNoise) {
    double before = 0.0;
    for (const double sigma_mm : {0.5e-3, 2e-3}) {
        core::Rng rng(3);
        LiveSpline curve(MaterialSide::left);
        for (std::uint64_t k = 0; k < 200; ++k) {
            const double t = 0.005 * static_cast<double>(k);
            curve.add(k, Ellipse::at(t) + sigma_mm * rng.normal() * Ellipse::normal(t));
        }
        double nearer = before;
        for (const double step : {0.05, 0.2, 0.8, 3.0}) {
            const double sigma = curve.predict(step).sigma_mm;
            EXPECT_GT(sigma, nearer);
            nearer = sigma;
        }
        before = curve.predict(0.05).sigma_mm;
        EXPECT_GT(before, sigma_mm);
        EXPECT_LT(curve.newest().sigma_mm, sigma_mm);
        EXPECT_LT(curve.point(LiveSpline::lag).sigma_mm, curve.newest().sigma_mm);
    }
}

}  // namespace
}  // namespace cmm::fitting
