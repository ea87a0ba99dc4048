// SPDX-License-Identifier: Apache-2.0
#include "fitting/corners.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/rng.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

/// Ball centres about the union of two discs: two arcs that meet in two concave corners, all known in closed form.
struct TwoDiscs {
    double a, b, turn, distance;
    Vec2 corner;  // the upper one; the other is its mirror image

    TwoDiscs(double radius_a, double radius_b, double turn_rad)
        : a(radius_a),
          b(radius_b),
          turn(turn_rad),
          distance(std::sqrt(a * a + b * b - 2.0 * a * b * std::cos(turn_rad))) {
        const double x = (distance * distance + a * a - b * b) / (2.0 * distance);
        corner = {x, std::sqrt(a * a - x * x)};
    }

    std::vector<Vec2> scan(double pitch, double start, double noise, core::Rng& rng) const {
        std::vector<Vec2> points;
        const double open_a = std::atan2(corner.y(), corner.x());
        const double open_b = pi - std::atan2(corner.y(), corner.x() - distance);
        const double length_a = a * 2.0 * (pi - open_a), length_b = b * 2.0 * (pi - open_b);
        const double total = length_a + length_b;
        const auto count = static_cast<int>(total / pitch);
        for (int i = 0; i < count; ++i) {
            const double s = std::fmod(total * (i + start) / count, total);
            const double angle = s < length_a ? open_a + s / a : pi + open_b + (s - length_a) / b;
            const Vec2 normal(std::cos(angle), std::sin(angle)), centre(s < length_a ? 0.0 : distance, 0.0);
            points.push_back(centre + ((s < length_a ? a : b) + noise * rng.normal()) * normal);
        }
        return points;
    }

    /// To the farther of the two circles: zero in the corners only.
    double off(const Vec2& p) const {
        return std::max(std::abs(p.norm() - a), std::abs((p - Vec2(distance, 0.0)).norm() - b));
    }
};

/// Clearly more than the noise is what a spline without a corner would round off, turn x pitch / 8, and clearly more
/// than a gap of its own does the flank turn there.
bool matters(double turn, double pitch, double noise, double flank_radius) {
    return turn * pitch / 8.0 > std::max(1.5 * noise, 1.5e-3) && turn > 1.7 * pitch / flank_radius;
}

TEST(Corners, AreFoundWhereTwoArcsMeet) {
    core::Rng rng(11);
    int scans = 0, missed = 0, extra = 0;
    for (const double degrees : {2.0, 5.0, 10.0, 20.0, 45.0, 90.0, 130.0})
        for (const double pitch : {0.05, 0.1, 0.2, 0.4})
            for (const double noise : {0.0, 1e-3, 3e-3})
                for (int trial = 0; trial < 6; ++trial) {
                    const double turn = degrees * pi / 180.0;
                    const TwoDiscs truth(6.0 + trial, 15.0 - 1.5 * trial, turn);
                    const auto points = truth.scan(pitch, rng.uniform(), noise, rng);
                    const auto corners = find_corners(points, noise);
                    int found = 0;
                    for (const auto& corner : corners) {
                        const double allowed = 1e-3 + 0.01 * pitch + 6.0 * noise;
                        if (truth.off(corner.position) > allowed) {
                            ++extra;
                            continue;
                        }
                        ++found;
                        EXPECT_NEAR(corner.turn_rad, turn, 6.0 * corner.turn_sigma_rad + 0.01)
                            << degrees << " " << pitch;
                        EXPECT_EQ(corner.after, (corner.before + 1) % points.size());
                        EXPECT_LE((points[corner.before] - corner.position).norm(), 2.5 * pitch);
                        EXPECT_NEAR(corner.arriving.dot(corner.leaving), std::cos(corner.turn_rad), 1e-9);
                    }
                    if (!matters(turn, pitch, noise, std::min(truth.a, truth.b))) continue;
                    ++scans;
                    missed += found != 2 ? 1 : 0;
                }
    EXPECT_GT(scans, 300);
    // At 3 um and 10 degrees a neighbouring gap may explain the points as well.
    EXPECT_LE(missed, scans / 100) << "of " << scans;
    EXPECT_LE(extra, scans / 100);
}

/// Bad points two places and more from the corner take nothing away, and make no corners.
TEST(Corners, BadPointsBesideThemDoNotHide) {
    core::Rng rng(12);
    int missed = 0, extra = 0, scans = 0;
    for (int trial = 0; trial < 200; ++trial) {
        const TwoDiscs truth(7.0, 12.0, rng.uniform(0.2, 1.5));
        auto points = truth.scan(0.2, rng.uniform(), 1e-3, rng);
        const auto n = points.size();
        std::size_t nearest = 0;
        for (std::size_t i = 0; i < n; ++i)
            if ((points[i] - truth.corner).norm() < (points[nearest] - truth.corner).norm()) nearest = i;
        const std::size_t at = (nearest + n + (trial % 2 == 0 ? 3 : n - 3)) % n;
        const Vec2 outward(rng.normal(), rng.normal());
        points[at] += rng.uniform(0.02, 0.4) * outward.normalized();
        if (trial % 3 == 0) points[(at + n / 3) % n] += 0.1 * outward.normalized();
        int found = 0;
        for (const auto& corner : find_corners(points, 1e-3))
            ++(truth.off(corner.position) < 0.006 ? found : extra);
        ++scans;
        missed += found < 2 ? 1 : 0;
    }
    EXPECT_LE(missed, scans / 50);
    EXPECT_EQ(extra, 0);
}

TEST(Corners, SmoothBladesHaveNone) {
    for (const auto& blade :
         {truth::envelope_blade({}), truth::envelope_blade({35, 6, 75, 30, 2.0, 0.4}),
          truth::ellipse_edged_blade(50, 25, 1.2, 0.4, 0.8, 0.25, 3.0), truth::naca_blade(45, 0.08, 0.05)}) {
        const auto centres = truth::ball_centres(blade, 1.0);
        for (const double pitch : {0.05, 0.1, 0.4})
            for (const double noise : {0.0, 1e-3, 3e-3})
                for (const double bad : {0.0, 0.02}) {
                    truth::ScanOptions options;
                    options.pitch = pitch;
                    options.noise = noise;
                    options.bad_share = bad;
                    const auto scan = truth::scan(centres, options);
                    const auto corners = find_corners(scan.points, noise);
                    EXPECT_TRUE(corners.empty()) << blade.name << " pitch " << pitch << " noise " << noise << " bad "
                                                 << bad << ": " << (corners.empty() ? 0.0 : corners[0].turn_rad);
                }
    }
}

/// A hollow that is rounder than the ball: with points on the fillet there is no corner.
TEST(Corners, AFilletWithPointsOnItIsNone) {
    core::Rng rng(13);
    for (const double radius : {0.2, 0.5, 1.0, 3.0}) {
        const double turn = 0.8, pitch = radius * turn / 5.0;
        std::vector<Vec2> points;  // a straight flank, a right-hand arc, a straight flank, closed by a wide loop
        const double angle = -0.5 * turn;
        const Vec2 centre(0.0, -radius);
        const auto add = [&](const Vec2& p) { points.push_back(p + 1e-3 * rng.normal() * Vec2(0.0, 1.0)); };
        const Vec2 start = centre + radius * Vec2(std::sin(angle), std::cos(angle)),
                   along(std::cos(angle), -std::sin(angle));
        for (int i = 60; i > 0; --i)
            add(start - i * pitch * along);
        for (int i = 0; i <= 5; ++i) {
            const double a = angle + turn * i / 5.0;
            add(centre + radius * Vec2(std::sin(a), std::cos(a)));
        }
        const Vec2 end = points.back(), on(std::cos(angle), std::sin(angle));
        for (int i = 1; i <= 60; ++i)
            add(end + i * pitch * on);
        const Vec2 last = points.back(), first = points.front(),
                   middle = 0.5 * (first + last) + Vec2(0.0, 20.0 * radius);
        const double wide = (last - middle).norm(), from = std::atan2(last.y() - middle.y(), last.x() - middle.x());
        const double to = std::atan2(first.y() - middle.y(), first.x() - middle.x()) + 2.0 * pi;
        for (int i = 1; i < 200; ++i)
            add(middle + wide * Vec2(std::cos(from + (to - from) * i / 200), std::sin(from + (to - from) * i / 200)));
        for (const auto& corner : find_corners(points, 1e-3))
            EXPECT_GT(std::min((corner.position - last).norm(), (corner.position - first).norm()), 1e9)
                << "radius " << radius << " at " << corner.before << " of " << points.size();
    }
}

TEST(Corners, FewPointsAreNoChain) {
    EXPECT_TRUE(find_corners(std::vector<Vec2>(20, Vec2(1, 2)), 1e-3).empty());
    EXPECT_TRUE(find_corners(std::vector<Vec2>(100, Vec2(1, 2)), 1e-3).empty());
}

}  // namespace
}  // namespace cmm::fitting
