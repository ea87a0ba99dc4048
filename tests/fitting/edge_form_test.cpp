// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_form.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;
constexpr double ball = 1.0;

void add(EdgePoints& edge, const Vec2& position, double direction) {
    const Vec2 normal(std::cos(direction), std::sin(direction));
    edge.points.push_back({position + ball * normal, normal});
}

/// An end that looks along +x: two corners with a flat between them (full height `flat` and two radii), measured every
/// `step` along the ball's path.
EdgePoints flat_end(double flat, double radius, double step = 0.05) {
    EdgePoints edge;
    edge.ball_mm = ball;
    const double turn = step / (radius + ball);
    for (double a = -0.5 * pi; a < 0.0; a += turn)
        add(edge, Vec2(0.0, -0.5 * flat) + radius * Vec2(std::cos(a), std::sin(a)), a);
    for (double y = -0.5 * flat; y < 0.5 * flat; y += step)
        add(edge, Vec2(radius, y), 0.0);
    for (double a = 0.0; a < 0.5 * pi; a += turn)
        add(edge, Vec2(0.0, 0.5 * flat) + radius * Vec2(std::cos(a), std::sin(a)), a);
    return edge;
}

EdgePoints ellipse_end(double along, double across, double step = 0.02) {
    EdgePoints edge;
    edge.ball_mm = ball;
    for (double e = -0.5 * pi; e < 0.5 * pi; e += step)
        add(edge, Vec2(along * std::cos(e), across * std::sin(e)),
            std::atan2(along * std::sin(e), across * std::cos(e)));
    return edge;
}

FormFinding form_of(const EdgePoints& edge) {
    return recognise_form(edge, 0, edge.points.size());
}

TEST(EdgeForm, FlatsBetweenCornersAreSquareOrBlunt) {
    const auto square = form_of(flat_end(1.0, 0.1));
    EXPECT_EQ(square.form, EdgeForm::square);
    EXPECT_NEAR(square.flat_mm, 1.0, 0.06) << "to a point's spacing";
    EXPECT_NEAR(square.corner_radius_mm, 0.1, 0.03);
    EXPECT_NE(square.text().find("square end: a flat of"), std::string::npos);
    const auto blunt = form_of(flat_end(0.6, 0.3));
    EXPECT_EQ(blunt.form, EdgeForm::blunt);
    EXPECT_NEAR(blunt.flat_mm, 0.6, 0.12) << "and the part of the corners that turns by less than 12 degrees";
    EXPECT_NE(blunt.text().find("blunt end"), std::string::npos);
}

TEST(EdgeForm, CirclesAndEllipsesAreRound) {
    for (const auto& edge : {flat_end(0.0, 0.4), ellipse_end(1.0, 1.0), ellipse_end(1.0, 0.5), ellipse_end(0.8, 0.4),
                             ellipse_end(0.5, 0.8)}) {
        const auto finding = form_of(edge);
        EXPECT_EQ(finding.form, EdgeForm::round);
        EXPECT_TRUE(finding.text().empty());
    }
}

TEST(EdgeForm, AnEdgeWithAGapIsPartial) {
    auto edge = ellipse_end(0.4, 0.4);
    const auto turned_between = [](const EdgePoint& p) { return p.normal.y() > 0.1 && p.normal.y() < 0.75; };
    std::erase_if(edge.points, turned_between);
    const auto finding = form_of(edge);
    EXPECT_EQ(finding.form, EdgeForm::partial);
    EXPECT_NEAR(finding.gap_rad, std::asin(0.75) - std::asin(0.1), 0.05);
    EXPECT_NE(finding.text().find("partial: no points over 4"), std::string::npos) << finding.text();
}

/// The direction of the normals is that of a fit, and noisy.
TEST(EdgeForm, StandsTheNoiseOfTheNormals) {
    core::Rng rng(7);
    for (int trial = 0; trial < 200; ++trial) {
        auto square = flat_end(1.0, 0.1), round = ellipse_end(0.4, 0.4, 0.1);
        for (auto* edge : {&square, &round}) {
            for (auto& p : edge->points) {
                const double a = 0.01 * rng.normal();
                p.centre += 0.001 * rng.normal() * p.normal;
                p.normal = Vec2(p.normal.x() - a * p.normal.y(), p.normal.y() + a * p.normal.x()).normalized();
            }
        }
        ASSERT_EQ(form_of(square).form, EdgeForm::square) << trial;
        ASSERT_EQ(form_of(round).form, EdgeForm::round) << trial;
    }
}

}  // namespace
}  // namespace cmm::fitting
