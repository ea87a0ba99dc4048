// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/parallel_curve.hpp"
#include "support/shapes.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;
using truth::ellipse, truth::through, truth::polygon, truth::Distance;

double signed_area(const std::vector<OffsetPoint>& points) {
    double twice = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
        twice += cross(points[i].position, points[(i + 1) % points.size()].position);
    return 0.5 * twice;
}

double longest_step(const std::vector<OffsetPoint>& points) {
    double longest = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i)
        longest = std::max(longest, (points[(i + 1) % points.size()].position - points[i].position).norm());
    return longest;
}

bool runs_backwards(const std::vector<OffsetPoint>& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        const auto &a = points[i], &b = points[(i + 1) % points.size()];
        const Vec2 normal = a.normal + b.normal, step = b.position - a.position;
        if (step.norm() > 1e-9 && step.dot(Vec2(-normal.y(), normal.x())) < 0.0) return true;
    }
    return false;
}

bool is_corner(const Offset& offset, const OffsetPoint& p) {
    return std::any_of(offset.corners.begin(), offset.corners.end(),
                       [&](const OffsetCorner& c) { return (c.position - p.position).norm() < 1e-12; });
}

void expect_parallel(const PiecewiseCubic& source, const Offset& offset, double distance) {
    for (const auto& p : offset.points) {
        if (is_corner(offset, p)) continue;
        EXPECT_NEAR((p.position - source.jet(p.t).position - distance * p.normal).norm(), 0.0, 1e-9);
        EXPECT_NEAR(p.normal.norm(), 1.0, 1e-12);
    }
    const Distance to_source(source);
    for (std::size_t i = 0; i < offset.points.size(); i += 23)
        EXPECT_NEAR(to_source.of(offset.points[i].position), std::abs(distance), 2e-9);
    for (const auto& corner : offset.corners)
        EXPECT_NEAR(to_source.of(corner.position), std::abs(distance), 2e-9);
}

TEST(Offset, OfAnEllipseIsParallelCounterClockwiseAndDense) {
    const auto source = ellipse(6, 4);
    for (const double distance : {-1.5, -0.8, 0.8, 20.0}) {
        const auto offset = offset_curve(source, distance, 1000);
        EXPECT_TRUE(offset.corners.empty());
        EXPECT_GE(offset.points.size(), 1000U);
        expect_parallel(source, offset, distance);
        // Steiner: A' = A + L d + pi d^2 for a convex curve without loops
        const ClosedCurve curve(source);
        EXPECT_NEAR(signed_area(offset.points), curve.area() + curve.length() * distance + pi * distance * distance,
                    1e-4 * curve.area() + 1e-4 * distance * distance);
    }
}

/// A24. A disc of radius r on the long axis of an ellipse touches it where cos^2 = (b^2 - r^2)/(b^2 - b^4/a^2).
TEST(Offset, LocalLoopsEndInTheTrueCorner) {
    const double a = 6, b = 2;
    const auto source = ellipse(a, b);
    for (const double r : {0.7, 1.0, 1.2, 1.9}) {
        const auto offset = offset_inwards(source, r, 2000);
        ASSERT_EQ(offset.corners.size(), 2U) << r;
        const double cosine = std::sqrt((b * b - r * r) / (b * b - std::pow(b, 4) / (a * a)));
        const double x = (a * a - b * b) / a * cosine;
        for (const auto& corner : offset.corners) {
            EXPECT_NEAR(std::abs(corner.position.x()), x, 1e-9) << r;
            EXPECT_NEAR(corner.position.y(), 0.0, 1e-9);
            EXPECT_NEAR(std::abs(source.jet(corner.from).position.x()), a * cosine, 1e-8);
            EXPECT_NEAR(std::abs(source.jet(corner.to).position.x()), a * cosine, 1e-8);
        }
        expect_parallel(source, offset, -r);
        EXPECT_FALSE(runs_backwards(offset.points));
        EXPECT_LT(longest_step(offset.points), 0.1);
    }
    EXPECT_TRUE(offset_inwards(source, 2.01, 2000).points.empty());
}

/// Two lobes of different size joined by a neck that is too narrow: opposite branches meet; the curve bends too
/// gently for a local loop.
TEST(Offset, OppositeBranchesThatMeetAreCutAndTheLargestPartIsKept) {
    const auto source = through(
        [](double t) {
            return Vec2(10 * std::cos(t) + 2 * std::cos(2 * t), std::sin(t) * (1.0 + 4.0 * std::pow(std::cos(t), 2)));
        },
        3000);
    const double d = 1.1;
    const auto offset = offset_inwards(source, d, 2000);
    ASSERT_EQ(offset.corners.size(), 1U);
    EXPECT_NEAR(offset.corners[0].position.y(), 0.0, 1e-9);
    expect_parallel(source, offset, -d);
    EXPECT_FALSE(runs_backwards(offset.points));
    const double corner = offset.corners[0].position.x();
    const bool right = std::all_of(offset.points.begin(), offset.points.end(),
                                   [&](const auto& p) { return p.position.x() > corner - 1e-9; });
    const bool left = std::all_of(offset.points.begin(), offset.points.end(),
                                  [&](const auto& p) { return p.position.x() < corner + 1e-9; });
    EXPECT_TRUE(right || left);
    EXPECT_GT(signed_area(offset.points), 0.0);
}

TEST(Offset, CornersOfTheSourceAreRoundedOnOneSideAndSharpOnTheOther) {
    const auto square = polygon({{0, 0}, {4, 0}, {4, 4}, {0, 4}});
    const auto outside = offset_curve(square, 1.0, 4000);
    EXPECT_TRUE(outside.corners.empty());
    EXPECT_NEAR(signed_area(outside.points), 16 + 16 + pi, 1e-3);
    const auto inside = offset_curve(square, -1.0, 1000);
    ASSERT_EQ(inside.corners.size(), 4U);
    for (const auto& corner : inside.corners)
        EXPECT_NEAR((corner.position - Vec2(2, 2)).cwiseAbs().minCoeff(), 1.0, 1e-12);
    EXPECT_NEAR(signed_area(inside.points), 4.0, 1e-9);
}

/// A ball that comes from outside into the corner of an L: it touches both flanks at a distance of its radius.
TEST(Offset, AConcaveCornerStopsTheBall) {
    const auto part = polygon({{0, 0}, {10, 0}, {10, 3}, {3, 3}, {3, 8}, {0, 8}});
    const auto centres = offset_curve(part, 1.0, 1000);
    ASSERT_EQ(centres.corners.size(), 1U);
    EXPECT_NEAR((centres.corners[0].position - Vec2(4, 4)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((part.jet(centres.corners[0].from).position - Vec2(4, 3)).norm(), 0.0, 1e-12);
    EXPECT_NEAR((part.jet(centres.corners[0].to).position - Vec2(3, 4)).norm(), 0.0, 1e-12);
}

/// Far round the curve a parameter has few digits left within a very short piece; where the curvature passes that of
/// the ball there, halving ends with them.
TEST(Offset, APieceHardlyLongerThanItsParameterTells) {
    constexpr double begin = 1000.0, width = 2e-4, ball = 1.0;
    const Vec2 origin(0.0, 0.0), start(-begin, 0.0);
    const PiecewiseCubic::Piece bent{origin, Vec2(1.0, 0.0), Vec2(0.0, 0.2), Vec2(0.0, 1e3)};
    const Vec2 end = bent[0] + width * (bent[1] + width * (bent[2] + width * bent[3])), top(0.0, begin);
    const auto side = [](const Vec2& from, const Vec2& to) {
        return PiecewiseCubic::Piece{from, (to - from).normalized(), Vec2::Zero(), Vec2::Zero()};
    };
    const double second = begin + width, third = second + (top - end).norm(), whole = third + (start - top).norm();
    const PiecewiseCubic source({0.0, begin, second, third, whole},
                                {side(start, origin), bent, side(end, top), side(top, start)}, true);
    const ParallelCurve parallel(source, -ball);
    std::vector<Stretch> of_bent;
    for (const Stretch& s : parallel.stretches())
        if (s.span == 1 && !s.about_corner) of_bent.push_back(s);
    ASSERT_EQ(of_bent.size(), 2U);
    EXPECT_FALSE(of_bent[0].backwards);
    EXPECT_TRUE(of_bent[1].backwards);
    EXPECT_NEAR(source.jet(of_bent[0].to).curvature(), 1.0 / ball, 1e-6);
}

/// On smooth random outlines, at random distances: every point is as far from the source as it should be, the curve
/// goes on without gaps or steps back, and what was not cut off is not nearer to the source than the distance.
TEST(Offset, AgreesWithTheDistanceOnRandomOutlines) {
    core::Rng rng(5);
    int trimmed = 0;
    for (int trial = 0; trial < 60; ++trial) {
        double amplitude[5], phase[5];
        for (int k = 0; k < 5; ++k) {
            amplitude[k] = 0.6 * rng.normal() / (k + 1);
            phase[k] = 6.0 * rng.uniform();
        }
        const auto source = through(
            [&](double t) {
                double r = 4.0;
                for (int k = 0; k < 5; ++k)
                    r += amplitude[k] * std::cos((k + 2) * t + phase[k]);
                return Vec2(2.0 * r * std::cos(t), r * std::sin(t));
            },
            60);
        const double distance = rng.uniform(-3.0, 8.0);
        const auto offset = offset_curve(source, distance, 3000);
        expect_parallel(source, offset, distance);
        if (offset.points.empty()) continue;
        trimmed += offset.corners.empty() ? 0 : 1;
        EXPECT_FALSE(runs_backwards(offset.points)) << trial;
        EXPECT_LT(longest_step(offset.points), 0.3) << trial;
        EXPECT_GT(signed_area(offset.points), 0.0);
        const Distance to_source(source);
        const auto cut = [&](double t) {
            return std::any_of(offset.corners.begin(), offset.corners.end(), [&](const OffsetCorner& c) {
                return c.from <= c.to ? t >= c.from && t <= c.to : t >= c.from || t <= c.to;
            });
        };
        for (int i = 0; i < 100; ++i) {
            const double t = source.period() * rng.uniform();
            const Jet jet = source.jet(t);
            if (cut(t)) continue;
            EXPECT_GT(to_source.of(jet.position + distance * jet.right_normal()), std::abs(distance) - 1e-8)
                << trial << " t " << t;
        }
    }
    EXPECT_GT(trimmed, 10);
}

TEST(Offset, LeanErrorsAreThoseOfThePaper) {
    // Seed 000, N2 and A22: per mm of ball radius at 10 degrees 15.4 um in the plane, 15.2 um to the surface, contact
    // 174 um off the plane.
    const auto error = lean_error(1.0, 10.0 * pi / 180.0);
    EXPECT_NEAR(error.in_plane_mm, 15.4e-3, 0.05e-3);
    EXPECT_NEAR(error.normal_mm, 15.2e-3, 0.05e-3);
    EXPECT_NEAR(error.height_mm, 174e-3, 0.5e-3);
}

}  // namespace
}  // namespace cmm::fitting
