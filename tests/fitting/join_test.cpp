// SPDX-License-Identifier: Apache-2.0
#include "fitting/join.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cmm::fitting {
namespace {

/// A stadium of ball centres: half circles of radius 1.4 about (0, 0) and (-20, 0) and straight sides, measured in
/// steps of 0.05 and 0.2 mm. The curve has a jump of the curvature at all four joints.
struct Stadium {
    static constexpr double radius = 1.4, length = 20.0;
    std::vector<Vec2> points;

    Stadium() {
        const int arc = 88, side = 100;
        for (int i = 0; i < arc; ++i) {
            const double a = std::numbers::pi * (i / double(arc) - 0.5);
            points.push_back(radius * Vec2(std::cos(a), std::sin(a)));
        }
        for (int i = 0; i < side; ++i)
            points.emplace_back(-length * i / side, radius);
        for (int i = 0; i < arc; ++i) {
            const double a = std::numbers::pi * (i / double(arc) + 0.5);
            points.push_back(Vec2(-length, 0.0) + radius * Vec2(std::cos(a), std::sin(a)));
        }
        for (int i = 0; i < side; ++i)
            points.emplace_back(-length + length * i / side, -radius);
    }
    static double distance(const Vec2& p) {
        const double x = std::clamp(p.x(), -length, 0.0);
        return (p - Vec2(x, 0.0)).norm() - radius;
    }
};

struct Case {
    PiecewiseCubic curve;
    EdgePatch patch;
};

/// The free form smooths the joints as a spline with knots every 0.8 mm does; the model knows the arc about (0, 0).
Case stadium_case() {
    const Stadium stadium;
    std::vector<Vec2> coarse;
    for (std::size_t i = 0; i < stadium.points.size(); i += 4)
        coarse.push_back(stadium.points[i]);
    const auto all = chord_parameters(stadium.points, true);
    std::vector<double> t;
    for (std::size_t i = 0; i < stadium.points.size(); i += 4)
        t.push_back(all[i]);
    t.push_back(all.back());
    Case out;
    out.curve = interpolate_periodic(coarse, t);
    EdgePoints edge;
    edge.ball_mm = 1.0;
    edge.noise = {1e-5, 100.0};
    std::vector<double> at;
    const std::size_t n = stadium.points.size();
    for (std::size_t k = n - 30; k < n + 118; ++k) {
        EdgePoint p;
        p.centre = stadium.points[k % n];
        const double inside = all[k % n];
        p.normal = out.curve.jet(inside).right_normal();
        p.residual_mm = (p.centre - out.curve.jet(inside).position).dot(p.normal);
        p.leverage = 0.25;
        edge.points.push_back(p);
        at.push_back(inside + (k >= n ? all.back() : 0.0));
    }
    ModelTrial trial;
    trial.model = EdgeModel::arc;
    trial.shape = ArcShape(ArcShape::Values(0.0, 0.0, 0.4));
    trial.begin = 34;
    trial.end = 114;
    const auto patch = make_patch(out.curve, edge, at, trial);
    EXPECT_TRUE(patch.has_value());
    if (patch) out.patch = *patch;
    return out;
}

TEST(Join, PutsTheJointsWhereTheArcEnds) {
    const Case c = stadium_case();
    EXPECT_NEAR(c.patch.after.joint.x(), 0.0, 0.02);
    EXPECT_NEAR(c.patch.after.joint.y(), 1.4, 0.001);
    EXPECT_NEAR(c.patch.before.joint.x(), 0.0, 0.02);
    EXPECT_NEAR(c.patch.before.joint.y(), -1.4, 0.001);
}

TEST(Join, BringsTheCurveToTheTruthAndKeepsTheRest) {
    const Case c = stadium_case();
    const auto joined = join_edges(c.curve, std::vector<EdgePatch>{c.patch});
    ASSERT_NEAR(joined.period(), c.curve.period(), 1e-12);
    double before = 0.0, after = 0.0, elsewhere = 0.0;
    for (double t = c.patch.before.t_free; t < c.patch.after.t_free; t += 0.005) {
        before = std::max(before, std::abs(Stadium::distance(c.curve.jet(t).position)));
        after = std::max(after, std::abs(Stadium::distance(joined.jet(t).position)));
    }
    for (double t = c.patch.after.t_free + 2.0; t < c.patch.before.t_free - 2.0 + c.curve.period(); t += 0.01)
        elsewhere = std::max(elsewhere, (joined.jet(t).position - c.curve.jet(t).position).norm());
    EXPECT_GT(before, 2e-3);
    EXPECT_LT(after, 3e-4);
    EXPECT_LT(elsewhere, 1e-5);
}

/// C2: at every break position, first and second derivative of both pieces agree (A21).
TEST(Join, TheJoinedCurveIsTwiceContinuouslyDifferentiable) {
    const Case c = stadium_case();
    const auto joined = join_edges(c.curve, std::vector<EdgePatch>{c.patch});
    const auto& pieces = joined.pieces();
    const auto& breaks = joined.breaks();
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const double h = breaks[k + 1] - breaks[k];
        const auto& p = pieces[k];
        const auto& next = pieces[(k + 1) % pieces.size()];
        EXPECT_LT((p[0] + h * (p[1] + h * (p[2] + h * p[3])) - next[0]).norm(), 1e-12);
        EXPECT_LT((p[1] + h * (2.0 * p[2] + 3.0 * h * p[3]) - next[1]).norm(), 1e-10);
        EXPECT_LT((2.0 * p[2] + 6.0 * h * p[3] - 2.0 * next[2]).norm(), 1e-8);
    }
}

TEST(Join, WithoutPatchesNothingChanges) {
    const std::vector<Vec2> points{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
    const auto curve = interpolate_periodic(points, chord_parameters(points, true));
    EXPECT_EQ(join_edges(curve, {}).breaks(), curve.breaks());
}

}  // namespace
}  // namespace cmm::fitting
