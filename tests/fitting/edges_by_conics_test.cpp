// SPDX-License-Identifier: Apache-2.0
/// Where edges of the three families end, by conics through them, and what that makes of the curve.
#include "fitting/edges_by_conics.hpp"
#include "fitting/closed_smoothing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/edge_conic.hpp"
#include "support/families.hpp"
#include "support/natural_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr double ball_mm = 1.0;

/// From the nose of the TE on.
std::vector<Vec2> points_of(const families::Blade& blade, std::uint64_t seed) {
    families::ScanOptions scanning;
    scanning.seed = seed;
    scanning.bad_share = 0.0;
    auto scan = families::scan(blade, scanning);
    const auto nose = std::min_element(scan.t.begin(), scan.t.end(),
                                       [](double a, double b) { return std::abs(a - 2.5) < std::abs(b - 2.5); });
    std::rotate(scan.points.begin(), scan.points.begin() + (nose - scan.t.begin()), scan.points.end());
    return scan.points;
}

/// How far ahead of the nearest corner a place of the curve is, and the step of the curvature there.
struct Corner {
    double ahead_mm = 0.0, step = 0.0;
};
Corner corner_at(const families::Blade& blade, const SmoothCurve& smooth, double t) {
    const Jet jet = smooth.curve.jet(t);
    const auto curvature = [&](double place) {
        const double k = blade.at(place < 0.0 ? place + 4.0 : place).curvature();
        return k / (1.0 + ball_mm * k);
    };
    Corner best;
    double nearest = 1e9;
    for (int corner = 0; corner < 4; ++corner) {
        const Vec2 off = jet.position - blade.ball_centre(corner, ball_mm);
        if (off.norm() >= nearest) continue;
        nearest = off.norm();
        best = {std::copysign(nearest, off.dot(jet.d1)), curvature(corner + 1e-9) - curvature(corner - 1e-9)};
    }
    return best;
}

TEST(EdgesByConics, KnowWhereTheyEndAndHowWell) {
    for (const auto& [family, most_off_mm] : {std::pair{families::Family::compressor, 0.008},
                                              {families::Family::turbine, 0.008},
                                              {families::Family::fan, 0.012}}) {
        double squares = 0.0, over_variance = 0.0, ends = 0.0, steps = 0.0;
        for (std::uint64_t k = 0; k < 40; ++k) {
            const auto blade = families::make(family, 500 + k);
            const auto points = points_of(blade, k + 1);
            const auto smooth = smooth_closed(points);
            ASSERT_TRUE(smooth);
            for (const ToldEdge& edge : edges_by_conics(*smooth, points, ball_mm))
                for (const ToldJoint& joint : {edge.begin, edge.end}) {
                    const Corner corner = corner_at(blade, *smooth, joint.t);
                    squares += corner.ahead_mm * corner.ahead_mm;
                    over_variance += std::pow(corner.ahead_mm / joint.sigma_mm, 2);
                    steps += std::pow(joint.step / corner.step - 1.0, 2);
                    ends += 1.0;
                }
        }
        std::cout << to_string(family) << ": " << ends << " ends, off " << 1e3 * std::sqrt(squares / ends) << " um, "
                  << std::sqrt(over_variance / ends) << " standard deviations, steps " << std::sqrt(steps / ends)
                  << "\n";
        EXPECT_GE(ends, 156.0) << "of 160";
        EXPECT_LT(std::sqrt(squares / ends), most_off_mm) << to_string(family);
        EXPECT_LT(std::sqrt(over_variance / ends), 1.6);
        EXPECT_GT(std::sqrt(over_variance / ends), 0.8);
        EXPECT_LT(std::sqrt(steps / ends), 0.03);
    }
}

/// A thickness law's nose is an ellipse nowhere up to a joint.
TEST(EdgesByConics, AreNoneOfNosesThatGoOverIntoTheirSides) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const natural::Blade blade(seed, false);
        const auto points = blade.scan(seed, ball_mm, 4.0).centres;
        const auto smooth = smooth_closed(points);
        ASSERT_TRUE(smooth);
        EXPECT_TRUE(edges_by_conics(*smooth, points, ball_mm).empty()) << seed;
    }
}

/// An edge with a form of its own.
TEST(EdgesByConics, AreNoneWhereThePointsLeaveThem) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const auto blade = families::make(families::Family::turbine, seed);
        auto points = points_of(blade, seed);
        for (Vec2& p : points) {
            const auto foot = blade.closest(p);
            if (families::Blade::part_of(foot.t) != families::Part::le) continue;
            p += 5e-3 * std::sin(6.0 * std::numbers::pi * foot.t) * blade.at(foot.t).normal();
        }
        const auto smooth = smooth_closed(points);
        ASSERT_TRUE(smooth);
        const auto told = edges_by_conics(*smooth, points, ball_mm);
        for (const ToldEdge& edge : told) {
            const Vec2 begin = smooth->curve.jet(edge.begin.t).position;
            EXPECT_GT((begin - blade.ball_centre(0.0, ball_mm)).norm(), 1.0) << "the LE has waves of 5 um";
        }
        EXPECT_LE(told.size(), 1U);
    }
}

TEST(EdgesByConics, BringTheCurveNearerToThePart) {
    struct Errors {
        double side_um = 0.0, edge_squares = 0.0, edge_count = 0.0, joint_squares = 0.0, joints = 0.0;
        double edge_rms_um() const { return std::sqrt(edge_squares / edge_count); }
        double joint_rms_mm() const { return std::sqrt(joint_squares / joints); }
    };
    constexpr std::size_t blades = 40;
    const auto add = [](const families::Blade& blade, const SmoothCurve& smooth, Errors& errors) {
        double largest = 0.0;
        for (int k = 0; k < 3000; ++k) {
            const auto foot = blade.closest(smooth.curve.jet(smooth.curve.period() * k / 3000).position);
            const double off_um = 1e3 * std::abs(foot.distance - ball_mm);
            const auto part = families::Blade::part_of(foot.t);
            if (part == families::Part::le || part == families::Part::te) {
                errors.edge_squares += off_um * off_um;
                errors.edge_count += 1.0;
            } else {
                largest = std::max(largest, off_um);
            }
        }
        errors.side_um += largest / double(blades);
        for (const CurvatureStep& joint : smooth.joints) {
            errors.joint_squares += std::pow(corner_at(blade, smooth, joint.t).ahead_mm, 2);
            errors.joints += 1.0;
        }
    };
    Errors untold, told;
    for (std::uint64_t k = 0; k < blades; ++k) {
        const auto blade = families::make(families::Family::fan, 700 + k);
        const auto points = points_of(blade, k + 1);
        ClosedSmoothing smoothing;
        const auto smooth = smoothing.run(points);
        ASSERT_TRUE(smooth);
        const auto with_edges = smoothing.with(edges_by_conics(*smooth, points, ball_mm));
        ASSERT_TRUE(with_edges);
        add(blade, *smooth, untold);
        add(blade, *with_edges, told);
    }
    std::cout << "sides' largest " << untold.side_um << " -> " << told.side_um << " um, edges rms "
              << untold.edge_rms_um() << " -> " << told.edge_rms_um() << " um, joints " << untold.joints << " off "
              << untold.joint_rms_mm() << " -> " << told.joints << " off " << told.joint_rms_mm() << " mm\n";
    EXPECT_LT(told.side_um, 0.8 * untold.side_um);
    EXPECT_LT(told.edge_rms_um(), 0.8 * untold.edge_rms_um());
    EXPECT_GE(told.joints, 4.0 * blades - 2.0);
    EXPECT_LT(told.joint_rms_mm(), 0.012);
}

/// What is told has to be borne out by the points.
TEST(EdgesByConics, AreNotBelievedAgainstThePoints) {
    const auto blade = families::make(families::Family::turbine, 3);
    const auto points = points_of(blade, 3);
    ClosedSmoothing smoothing;
    const auto smooth = smoothing.run(points);
    ASSERT_TRUE(smooth);
    auto told = edges_by_conics(*smooth, points, ball_mm);
    ASSERT_FALSE(told.empty());
    ToldEdge& edge = told.front();
    const double place = edge.begin.t;
    edge.begin.t = smooth->curve.wrap(place - 5.0);
    const auto with_edges = smoothing.with(told);
    ASSERT_TRUE(with_edges);
    const auto nearest_mm = [&](double t) {
        double nearest = 1e9;
        for (const CurvatureStep& joint : with_edges->joints)
            nearest = std::min(nearest, std::abs(std::remainder(joint.t - t, smooth->curve.period())));
        return nearest;
    };
    EXPECT_GT(nearest_mm(edge.begin.t), 1.0) << "none is there";
    EXPECT_LT(nearest_mm(place), 0.05) << "the curve has it where it was";
}

/// Ball centres about a half ellipse, by equal angles.
EdgePoints about_ellipse(double along, double across, double sigma_mm) {
    EdgePoints edge;
    edge.ball_mm = ball_mm;
    edge.noise = {sigma_mm, 500.0};
    core::Rng rng(7);
    constexpr int count = 80;
    for (int k = 0; k <= count; ++k) {
        const double angle = (1.0 * k / count - 0.5) * std::numbers::pi;
        const Vec2 normal = Vec2(across * std::cos(angle), along * std::sin(angle)).normalized();
        const Vec2 part(along * std::cos(angle), across * std::sin(angle));
        edge.points.push_back({part + (ball_mm + sigma_mm * rng.normal()) * normal, normal, 0.0, 0.2});
    }
    edge.nose = count / 2;
    return edge;
}

TEST(EdgesByConics, AreArcsOrEllipses) {
    for (const double along : {0.5, 1.5, 3.0}) {
        const EdgePoints edge = about_ellipse(along, 0.5, 1e-3);
        std::vector<double> curvature;  // as a curve has it
        for (const EdgePoint& p : edge.points) {
            const double w2 = along * along * p.normal.x() * p.normal.x() + 0.25 * p.normal.y() * p.normal.y();
            curvature.push_back(w2 * std::sqrt(w2) / std::pow(0.5 * along, 2) * (1.0 + 0.2 * p.normal.y()));
        }
        const auto conic = ConicFitter(edge, curvature).fit({0, edge.points.size()});
        ASSERT_TRUE(conic) << along;
        const double nose = 0.25 / along;
        EXPECT_NEAR(conic->radius_mm(Vec2::UnitX()), nose, 0.03 * nose);
        EXPECT_NEAR(conic->radius_mm(Vec2::UnitY()), along * along / 0.5, 0.03 * along * along / 0.5);
        const Vec2 at(0.0, 0.5 + ball_mm);
        const double off = turn_angle(Vec2::UnitY(), conic->normal(at, Vec2::UnitY()));
        EXPECT_LT(std::abs(off), 4.0 * std::sqrt(conic->direction_variance(at, Vec2::UnitY())));
    }
}

}  // namespace
}  // namespace cmm::fitting
