// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>

#include "core/rng.hpp"
#include "fitting/model_fitter.hpp"

namespace cmm::fitting {
namespace {

using std::numbers::pi;

/// Position and outward normal of a part's edge and sides by the share -1 ... 1 of the edge, beyond it of the sides,
/// from formulas of its own. The nose looks along +x.
struct Place {
    Vec2 position, normal;
};
using Outline = std::function<Place(double)>;

Place on_side(const Place& joint, double way, double sign) {  // a side of 60 mm radius that continues the tangent
    constexpr double radius = 60.0;
    const double turn = sign * way / radius;
    const Vec2 n = joint.normal, centre = joint.position - radius * n;
    const Vec2 turned(std::cos(turn) * n.x() - std::sin(turn) * n.y(), std::sin(turn) * n.x() + std::cos(turn) * n.y());
    return {centre + radius * turned, turned};
}

Outline with_sides(const std::function<Place(double)>& edge, double side_step) {
    return [=](double w) {
        if (std::abs(w) <= 1.0) return edge(w);
        return on_side(edge(w > 0 ? 1.0 : -1.0), (std::abs(w) - 1.0) * side_step, w > 0 ? 1.0 : -1.0);
    };
}

Outline ellipse(double a, double b) {
    return with_sides(
        [=](double w) -> Place {
            const double e = 1.5 * w;
            return {{a * std::cos(e), b * std::sin(e)}, Vec2(b * std::cos(e), a * std::sin(e)).normalized()};
        },
        7.0);
}

Outline parabola(double radius, double half_width) {
    return with_sides(
        [=](double w) -> Place {
            const double y = half_width * w;
            return {{-y * y / (2 * radius), y}, Vec2(1.0, y / radius).normalized()};
        },
        7.0);
}

Outline two_arcs(double first, double second) {  // they meet at the nose
    return with_sides(
        [=](double w) -> Place {
            const double r = w < 0 ? first : second;
            const Vec2 n(std::cos(1.5 * w), std::sin(1.5 * w));
            return {Vec2(-r, 0.0) + r * n, n};
        },
        7.0);
}

/// |x/a|^p + |y/b|^p = 1 with p = 2.6: none of the models.
Outline superellipse(double a, double b) {
    return with_sides(
        [=](double w) -> Place {
            constexpr double p = 2.6;
            const double e = 1.4 * w, c = std::cos(e), s = std::abs(std::sin(e));
            const double x = std::pow(c, 2 / p), y = std::copysign(std::pow(s, 2 / p), w);
            return {{a * x, b * y},
                    Vec2(std::pow(x, p - 1) / a, std::copysign(std::pow(std::abs(y), p - 1), w) / b).normalized()};
        },
        7.0);
}

/// 72 points on the edge, 14 on either side; the free form as it would be: leverage 0.17, on the edge no misfit.
EdgePoints measured(const Outline& outline, double ball, double sigma, core::Rng& rng) {
    constexpr double leverage = 0.17;
    EdgePoints edge;
    edge.ball_mm = ball;
    edge.noise = {sigma, 600.0};
    for (int i = -50; i < 50; ++i) {
        const double w = (i + 0.5 + 0.1 * rng.uniform(-1.0, 1.0)) / 36.0;
        const Place place = outline(w);
        const double noise = sigma * rng.normal();
        EdgePoint point;
        point.centre = place.position + (ball + noise) * place.normal;
        point.normal = place.normal;
        point.residual_mm = std::sqrt(1.0 - leverage) * noise;
        point.leverage = leverage;
        edge.points.push_back(point);
    }
    edge.nose = 50;
    return edge;
}

EdgeModel chosen(const EdgeChoice& choice) {
    return choice.chosen ? choice.trials[*choice.chosen].model : EdgeModel::free;
}

double share_of_right_choices(const Outline& outline, EdgeModel right, double sigma) {
    int found = 0;
    constexpr int runs = 300;
    for (int k = 0; k < runs; ++k) {
        core::Rng rng(1000 + k);
        found += chosen(choose_edge_model(measured(outline, 1.0, sigma, rng))) == right;
    }
    return found / static_cast<double>(runs);
}

/// A circle that turns by so much to either side of the nose.
Outline wedge(double radius, double turn_rad) {
    return with_sides(
        [=](double w) -> Place {
            const Vec2 n(std::cos(turn_rad * w), std::sin(turn_rad * w));
            return {radius * n, n};
        },
        7.0);
}

/// A window that ends where the normal has turned by 75 degrees takes in a side where the edge turns by less.
TEST(EdgeModel, AWindowThatGoesOnAlongASideIsToldFromALongEdge) {
    for (const double ball : {0.0, 1.0})
        for (const double sigma : {0.0, 3e-3}) {
            core::Rng rng(1);
            const auto reaches_a_side = [&](const Outline& outline, double turn_rad) {
                const EdgePoints edge = measured(outline, ball, sigma, rng);
                const ModelFitter fitter(edge);
                return fitter.reaches_a_side(fitter.turning_by(turn_rad));
            };
            EXPECT_TRUE(reaches_a_side(wedge(0.25, 1.1), 1.3));
            EXPECT_TRUE(reaches_a_side(wedge(0.4, 1.25), 1.3));
            EXPECT_FALSE(reaches_a_side(wedge(0.4, 1.1), 1.0));
            EXPECT_FALSE(reaches_a_side(wedge(0.4, 1.4), 1.3));
            EXPECT_FALSE(reaches_a_side(ellipse(1.6, 0.4), 1.3));
            EXPECT_FALSE(reaches_a_side(parabola(0.25, 1.3), 1.3));
        }
}

/// An edge that turns by 34 degrees to either side has no window without a side: what was tried is told all the same.
TEST(EdgeModel, WhereEveryWindowTakesInASideTheReasonIsTold) {
    core::Rng rng(1);
    for (const auto request : {std::optional<EdgeModel>(), std::optional(EdgeModel::arc)}) {
        const EdgeChoice choice = choose_edge_model(measured(wedge(0.4, 0.6), 1.0, 1e-3, rng), request);
        EXPECT_FALSE(choice.chosen);
        ASSERT_FALSE(choice.trials.empty());
        EXPECT_EQ(choice.trials.front().model, EdgeModel::arc);
        EXPECT_FALSE(choice.trials.front().why.empty());
    }
}

TEST(EdgeModel, PicksTheFormThatTheEdgeHas) {
    EXPECT_GE(share_of_right_choices(ellipse(0.4, 0.4), EdgeModel::arc, 1e-3), 0.95);
    EXPECT_GE(share_of_right_choices(ellipse(0.15, 0.15), EdgeModel::arc, 1e-3), 0.95);
    EXPECT_GE(share_of_right_choices(ellipse(0.6, 0.3), EdgeModel::ellipse, 1e-3), 0.95);
    EXPECT_GE(share_of_right_choices(ellipse(0.4, 0.3), EdgeModel::ellipse, 1e-3), 0.95);
    EXPECT_GE(share_of_right_choices(ellipse(0.9, 0.3), EdgeModel::ellipse, 3e-3), 0.95);
    EXPECT_GE(share_of_right_choices(two_arcs(0.3, 0.6), EdgeModel::double_arc, 1e-3), 0.95);
    EXPECT_GE(share_of_right_choices(two_arcs(0.5, 0.3), EdgeModel::double_arc, 1e-3), 0.95);
    EXPECT_GE(share_of_right_choices(parabola(0.25, 0.8), EdgeModel::parabola, 1e-3), 0.95);
}

/// It seldom finds strong evidence for an edge that has none of the forms, and then stays within the noise.
TEST(EdgeModel, ImposesNoFormThatThePointsDoNotHave) {
    for (const double sigma : {1e-3, 3e-3}) {
        int picked = 0;
        constexpr int runs = 100;
        for (int k = 0; k < runs; ++k) {
            core::Rng rng(4000 + k), again(4000 + k);
            const EdgePoints edge = measured(superellipse(0.6, 0.35), 1.0, sigma, rng);
            const EdgePoints exact = measured(superellipse(0.6, 0.35), 1.0, 1e-300, again);
            const EdgeChoice choice = choose_edge_model(edge);
            if (!choice.chosen) continue;
            const ModelTrial& trial = choice.trials[*choice.chosen];
            if (trial.gain < 6.0) continue;
            ++picked;
            for (std::size_t i = trial.begin; i < trial.end; ++i) {
                const double off = std::visit(
                    [&](const auto& shape) {
                        if constexpr (std::is_same_v<std::decay_t<decltype(shape)>, std::monostate>) {
                            return 1.0;
                        } else {
                            const auto foot = shape.foot(exact.points[i].centre, exact.points[i].normal);
                            return (exact.points[i].centre - foot.position).dot(foot.normal) - 1.0;
                        }
                    },
                    trial.shape);
                EXPECT_LT(std::abs(off), 2.5 * sigma);
            }
        }
        EXPECT_LT(picked, 0.15 * runs) << sigma;
    }
}

/// The curvature drops by nine tenths there: to within some points of 0.05 mm, of the right side most often.
TEST(EdgeModel, FindsWhereTheModelEnds) {
    int near = 0, past = 0;
    constexpr int runs = 200;
    for (int k = 0; k < runs; ++k) {
        core::Rng rng(k);
        const EdgeChoice choice = choose_edge_model(measured(ellipse(0.6, 0.3), 1.0, 1e-3, rng));
        if (!choice.chosen) continue;
        const ModelTrial& trial = choice.trials[*choice.chosen];
        near += trial.begin >= 13 && trial.begin <= 18;
        near += trial.end >= 82 && trial.end <= 87;
        past += trial.begin < 13;
        past += trial.end > 87;
    }
    EXPECT_GE(near, 0.8 * 2 * runs);
    EXPECT_LE(past, 0.01 * 2 * runs);
}

TEST(EdgeModel, ParametersLieWithinTheirUncertainty) {
    int covered_roundness = 0, covered_radius = 0, fits = 0;
    constexpr int runs = 500;
    for (int k = 0; k < runs; ++k) {
        core::Rng rng(70000 + k);
        const EdgeChoice choice = choose_edge_model(measured(ellipse(0.6, 0.3), 1.0, 1e-3, rng), EdgeModel::ellipse);
        if (!choice.chosen) continue;
        ++fits;
        const ModelTrial& trial = choice.trials[*choice.chosen];
        const auto& shape = std::get<EllipseShape>(trial.shape);
        const double t = coverage_95(trial.noise.freedom);
        covered_roundness += std::abs(shape.values()[4] - 0.25) <= t * std::sqrt(trial.covariance(4, 4));
        covered_radius += std::abs(shape.values()[3] - 0.15) <= t * std::sqrt(trial.covariance(3, 3));
    }
    EXPECT_GE(fits, 0.98 * runs);
    EXPECT_GE(covered_roundness, 0.92 * fits);
    EXPECT_GE(covered_radius, 0.92 * fits);
    EXPECT_LE(covered_roundness, 0.98 * fits);
    EXPECT_LE(covered_radius, 0.98 * fits);
}

TEST(EdgeModel, ARequestIsTriedAloneAndRefusedWhereThePointsRefuseIt) {
    core::Rng rng(9);
    const EdgePoints edge = measured(ellipse(0.9, 0.3), 1.0, 1e-3, rng);
    const EdgeChoice free = choose_edge_model(edge, EdgeModel::free);
    EXPECT_TRUE(free.trials.empty());
    EXPECT_FALSE(free.chosen);
    const EdgeChoice both = choose_edge_model(edge, EdgeModel::double_arc);
    ASSERT_EQ(both.trials.size(), 1U);
    EXPECT_EQ(both.trials[0].model, EdgeModel::double_arc);
    EXPECT_EQ(chosen(choose_edge_model(edge, EdgeModel::ellipse)), EdgeModel::ellipse);
    const EdgeChoice arc = choose_edge_model(edge, EdgeModel::arc);
    if (arc.chosen) {
        EXPECT_LT(arc.trials[0].end - arc.trials[0].begin, 36U) << "at most the tip of it";
    }
}

TEST(EdgeModel, SparseOrEmptyDataGiveNoModelAndNoHarm) {
    EXPECT_FALSE(choose_edge_model({}).chosen);
    core::Rng rng(1);
    EdgePoints edge = measured(ellipse(0.6, 0.3), 1.0, 1e-3, rng);
    edge.points = {edge.points[20], edge.points[50], edge.points[80]};
    edge.nose = 1;
    EXPECT_FALSE(choose_edge_model(edge).chosen);
    for (int k = 0; k < 200; ++k) {
        EdgePoints garbage;
        garbage.noise = {1e-3, 10.0};
        garbage.ball_mm = k % 2;
        for (int i = 0; i < 40; ++i) {
            EdgePoint p;
            p.centre = Vec2(rng.normal(), rng.normal()) * std::pow(10.0, rng.uniform(-6.0, 6.0));
            const double a = rng.uniform(-pi, pi);
            p.normal = {std::cos(a), std::sin(a)};
            p.residual_mm = 1e-3 * rng.normal();
            garbage.points.push_back(p);
        }
        garbage.nose = static_cast<std::size_t>(k % 40);
        (void)choose_edge_model(garbage);
    }
}

}  // namespace
}  // namespace cmm::fitting
