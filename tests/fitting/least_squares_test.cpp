// SPDX-License-Identifier: Apache-2.0
#include "fitting/least_squares.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/rng.hpp"
#include "support/recursion.hpp"

namespace cmm::fitting {
namespace {

struct Problem {
    std::vector<double> t, x, y, weights, breaks;
    PointColumns columns() const { return {t, x, y}; }
};

Problem noisy_ellipse(std::size_t n, std::size_t spans) {
    core::Rng rng(n);
    Problem p;
    for (std::size_t i = 0; i < n; ++i) {
        const double t = (static_cast<double>(i) + 0.9 * rng.uniform()) / static_cast<double>(n);
        const double angle = 2.0 * std::numbers::pi * t;
        p.t.push_back(5.0 * t);
        p.x.push_back(3.0 * std::cos(angle) + 0.01 * rng.normal());
        p.y.push_back(std::sin(angle) + 0.01 * rng.normal());
        p.weights.push_back(0.5 + rng.uniform());
    }
    p.breaks = {0.0};
    for (std::size_t k = 0; k < spans; ++k)
        p.breaks.push_back(p.breaks.back() + 0.5 + rng.uniform());
    for (double& b : p.breaks)
        b *= 5.0 / p.breaks.back();
    p.breaks.back() = 5.0;
    return p;
}

/// The same problem by QR on the dense design matrix.
Eigen::MatrixXd dense_controls(const Problem& p, const LeastSquaresSpline& fit) {
    const auto n = static_cast<Eigen::Index>(p.t.size());
    const auto controls = static_cast<Eigen::Index>(fit.controls().size());
    Eigen::MatrixXd design = Eigen::MatrixXd::Zero(n, controls), points(n, 2);
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const double root = std::sqrt(p.weights[at]);
        for (std::size_t j = 0; j + 4 < fit.knots().size(); ++j)
            design(i, static_cast<Eigen::Index>(j) % controls) += root * truth::basis(fit.knots(), j, 3, p.t[at]);
        points.row(i) << root * p.x[at], root * p.y[at];
    }
    return design.householderQr().solve(points);
}

TEST(CubicBasis, IsTheRecursionAlsoAtRepeatedKnots) {
    for (const std::vector<double>& knots :
         {std::vector<double>{0, 1, 1.5, 3, 3.2, 5, 6, 7}, std::vector<double>{2, 2, 2, 2, 3, 5, 6, 9},
          std::vector<double>{0, 1, 2, 2.5, 4, 4, 4, 4}}) {
        const CubicBasis basis = cubic_basis(&knots[1]);
        for (const double w : {0.0, 0.2, 0.5, 0.99}) {
            const auto b = basis.at(w);
            for (std::size_t a = 0; a < 4; ++a)
                EXPECT_NEAR(b[a], truth::basis(knots, a, 3, knots[3] + w * (knots[4] - knots[3])), 1e-14);
            EXPECT_NEAR(b[0] + b[1] + b[2] + b[3], 1.0, 1e-14);
        }
    }
}

TEST(LeastSquaresSpline, AgreesWithADenseSolver) {
    for (const bool closed : {true, false}) {
        for (const std::size_t spans : {7U, 12U, 40U}) {
            const Problem p = noisy_ellipse(400, spans);
            LeastSquaresSpline fit;
            ASSERT_TRUE(fit.set_knots(p.breaks, closed));
            ASSERT_TRUE(fit.add(p.columns(), p.weights));
            ASSERT_TRUE(fit.solve());
            const Eigen::MatrixXd expected = dense_controls(p, fit);
            const PiecewiseCubic curve = fit.curve();
            for (std::size_t j = 0; j < fit.controls().size(); ++j)
                EXPECT_LT((fit.controls()[j] - expected.row(static_cast<Eigen::Index>(j)).transpose()).norm(), 1e-11);
            for (const double t : {0.0, 0.3, 2.2, 4.999}) {
                Vec2 sum = Vec2::Zero();
                for (std::size_t j = 0; j + 4 < fit.knots().size(); ++j)
                    sum += truth::basis(fit.knots(), j, 3, t) * fit.controls()[j % fit.controls().size()];
                EXPECT_LT((curve.jet(t).position - sum).norm(), 1e-12) << closed << " " << t;
            }
        }
    }
}

TEST(LeastSquaresSpline, ReproducesAPeriodicSplineFromItsOwnPoints) {
    const std::vector<Vec2> corners{{0, 0}, {2, -1}, {4, 0}, {5, 2}, {4, 3}, {2, 3.5}, {1, 3}, {-1, 1.5}};
    const PiecewiseCubic truth = interpolate_periodic(corners, chord_parameters(corners, true));
    Problem p;
    for (int i = 0; i < 100; ++i) {
        p.t.push_back(truth.period() * i / 100.0);
        p.x.push_back(truth.jet(p.t.back()).position.x());
        p.y.push_back(truth.jet(p.t.back()).position.y());
    }
    const auto curve = fit_fixed_knots(p.columns(), truth.breaks(), true);
    ASSERT_TRUE(curve);
    for (double t = 0.0; t < truth.period(); t += 0.01)
        EXPECT_LT((curve->jet(t).position - truth.jet(t).position).norm(), 1e-13);
}

TEST(LeastSquaresSpline, AUsedWorkspaceGivesTheSameBits) {
    const Problem first = noisy_ellipse(300, 20), second = noisy_ellipse(500, 31);
    LeastSquaresSpline used, fresh;
    ASSERT_TRUE(used.set_knots(second.breaks, true) && used.add(second.columns()) && used.solve());
    for (LeastSquaresSpline* fit : {&used, &fresh})
        ASSERT_TRUE(fit->set_knots(first.breaks, true) && fit->add(first.columns()) && fit->solve());
    for (std::size_t j = 0; j < 20; ++j)
        EXPECT_TRUE(used.controls()[j] == fresh.controls()[j]);
}

TEST(LeastSquaresSpline, RefusesBrokenInput) {
    const Problem good = noisy_ellipse(300, 20);
    EXPECT_FALSE(fit_fixed_knots(good.columns(), std::vector<double>{0, 1, 2, 3, 4, 5, 6}, true)) << "six spans";
    EXPECT_FALSE(fit_fixed_knots(good.columns(), {}, false));
    Problem p = good;
    p.breaks[4] = p.breaks[3];
    EXPECT_FALSE(fit_fixed_knots(p.columns(), p.breaks, true));
    p = good;
    std::swap(p.t[10], p.t[11]);
    const auto refused = fit_fixed_knots(p.columns(), p.breaks, true);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("point 11"), std::string::npos);
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
        p = good;
        p.t[20] = bad;
        EXPECT_FALSE(fit_fixed_knots(p.columns(), p.breaks, true));
        p = good;
        p.y[20] = bad;
        EXPECT_FALSE(fit_fixed_knots(p.columns(), p.breaks, true));
    }
    p = good;
    p.x.pop_back();
    EXPECT_FALSE(fit_fixed_knots(p.columns(), p.breaks, true));
    p.t.resize(10), p.x.resize(10), p.y.resize(10);
    EXPECT_FALSE(fit_fixed_knots(p.columns(), p.breaks, true)) << "more controls than points";
}

}  // namespace
}  // namespace cmm::fitting
