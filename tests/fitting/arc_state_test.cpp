// SPDX-License-Identifier: Apache-2.0
#include "fitting/arc_state.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

ArcState state_of(const Vec2& position, double heading, double curvature) {
    ArcState state;
    state.position = position;
    state.tangent = {std::cos(heading), std::sin(heading)};
    state.curvature = curvature;
    return state;
}

TEST(ArcState, FindsTheFootOnACircleEitherWayAndBackwards) {
    for (const double radius : {0.7, 5.0, 1e4}) {
        for (const double sense : {1.0, -1.0}) {
            for (const double turn : {-1.2, -0.05, 1e-5, 0.3, 1.4}) {
                const double off = 0.03;
                // The centre lies to the left of the travel when the curve turns left.
                const Vec2 centre(3.0, -2.0);
                const double from = 0.8;
                const auto on = [&](double angle, double r) {
                    return Vec2(centre + r * Vec2(std::cos(from + sense * angle), std::sin(from + sense * angle)));
                };
                const auto state = state_of(on(0.0, radius), from + sense * std::numbers::pi / 2, sense / radius);
                const auto foot = foot_on_arc(state, on(turn, radius - off));
                ASSERT_TRUE(foot.reached);
                EXPECT_NEAR(foot.length, radius * turn, 1e-9 * radius);
                EXPECT_NEAR(foot.turn, sense * turn, 1e-9);
                EXPECT_NEAR(foot.offset, sense * off, 1e-15 * radius * radius + 1e-12);
                const double heading = from + sense * (turn + std::numbers::pi / 2);
                EXPECT_LT((foot.tangent - Vec2(std::cos(heading), std::sin(heading))).norm(), 1e-11);
            }
        }
    }
}

TEST(ArcState, OnAStraightLineTheFootIsTheProjection) {
    const auto foot = foot_on_arc(state_of({1.0, 1.0}, 0.0, 0.0), {4.0, 1.5});
    ASSERT_TRUE(foot.reached);
    EXPECT_DOUBLE_EQ(foot.length, 3.0);
    EXPECT_DOUBLE_EQ(foot.offset, 0.5);
    EXPECT_DOUBLE_EQ(foot.reach, 3.0);
}

TEST(ArcState, AnArcDoesNotReachBeyondAQuarterTurn) {
    EXPECT_FALSE(foot_on_arc(state_of({0.0, 0.0}, 0.0, 1.0), {0.1, 1.2}).reached);
    EXPECT_FALSE(foot_on_arc(state_of({0.0, 0.0}, 0.0, 1.0), {std::nan(""), 0.0}).reached);
}

/// How the foot's offset answers to the state, by differences: what the covariance is carried with.
TEST(ArcState, CarriesTheVarianceThatDifferencesShow) {
    for (const double curvature : {0.0, 0.6, -0.3}) {
        auto state = state_of({0.3, 0.2}, 0.4, curvature);
        state.covariance = {4e-6, 1e-6, -2e-6, 9e-4, 1e-4, 0.04};
        const Vec2 point = state.position + 0.9 * state.tangent;
        const auto foot = foot_on_arc(state, point);
        Eigen::Vector3d answer;
        constexpr double h = 1e-6;
        for (int i = 0; i < 3; ++i) {
            Triple by{};
            by.at(static_cast<std::size_t>(i)) = h;
            answer[i] = (foot.offset - foot_on_arc(displaced(state, by), point).offset) / h;
        }
        Eigen::Matrix3d p;
        p << 4e-6, 1e-6, -2e-6, 1e-6, 9e-4, 1e-4, -2e-6, 1e-4, 0.04;
        const double expected = answer.dot(p * answer);
        EXPECT_NEAR(carried_variance(state, foot), expected, 1e-4 * expected) << curvature;
        EXPECT_NEAR(carried_covariance(state, foot, 0.0).dd, expected, 1e-4 * expected) << curvature;
    }
}

/// Forward and back through noisy points near a line, against the same least squares solved at once.
TEST(ArcState, FilterAndSmootherAreTheDenseLeastSquares) {
    constexpr int n = 9;
    constexpr double noise = 1e-14, rate = 3e-10;  // so small that the line stays straight
    const std::vector<double> step{0.1, 0.3, 0.1, 0.05, 0.4, 0.1, 0.2, 0.1};
    const Eigen::Vector3d prior(1e-12, 1e-11, 1e-10);
    core::Rng rng(5);
    std::vector<Vec2> points{{0.0, 0.0}};
    for (const double s : step)
        points.emplace_back(points.back().x() + s, 1e-7 * rng.normal());

    std::vector<ArcState> filtered;
    std::vector<ArcFoot> feet(n);
    std::vector<Symmetric3> predicted(n);
    std::vector<Triple> correction(n);
    ArcState state = state_of({0.0, 0.0}, 0.0, 0.0);
    state.covariance = {prior[0], 0.0, 0.0, prior[1], 0.0, prior[2]};
    filtered.push_back(state);
    for (int i = 1; i < n; ++i) {
        feet[i] = foot_on_arc(filtered.back(), points[i]);
        predicted[i] = carried_covariance(filtered.back(), feet[i], rate);
        const auto update = updated(filtered.back(), feet[i], points[i], predicted[i], noise);
        correction[i] = update.correction;
        filtered.push_back(update.state);
    }

    // Unknowns (d, d', k) of each point; rows: prior, process noise, points; all over their standard deviations.
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    Eigen::VectorXd moment = Eigen::VectorXd::Zero(3 * n);
    information.topLeftCorner<3, 3>() = prior.cwiseInverse().asDiagonal();
    for (int i = 1; i < n; ++i) {
        const double s = step[i - 1];
        Eigen::Matrix3d f;
        f << 1, s, s * s / 2, 0, 1, s, 0, 0, 1;
        Eigen::Matrix3d q;
        q << std::pow(s, 5) / 20, std::pow(s, 4) / 8, std::pow(s, 3) / 6, std::pow(s, 4) / 8, std::pow(s, 3) / 3,
            s * s / 2, std::pow(s, 3) / 6, s * s / 2, s;
        Eigen::Matrix<double, 3, 6> row;
        row << -f, Eigen::Matrix3d::Identity();
        information.block<6, 6>(3 * (i - 1), 3 * (i - 1)) += row.transpose() * (rate * q).inverse() * row;
        information(3 * i, 3 * i) += 1.0 / noise;
        moment[3 * i] += points[i].y() / noise;
    }
    const Eigen::MatrixXd covariance = information.inverse();
    const Eigen::VectorXd solution = covariance * moment;

    Triple by{};
    Symmetric3 p = filtered.back().covariance;
    for (int i = n - 1; i >= 0; --i) {
        const ArcState smoothed = displaced(filtered[i], by);
        const double scale = std::sqrt(noise);
        EXPECT_NEAR(smoothed.position.y(), solution[3 * i], 1e-5 * scale) << i;
        EXPECT_NEAR(std::atan2(smoothed.tangent.y(), smoothed.tangent.x()), solution[3 * i + 1], 1e-4 * scale) << i;
        EXPECT_NEAR(smoothed.curvature, solution[3 * i + 2], 1e-3 * scale) << i;
        EXPECT_NEAR(p.dd, covariance(3 * i, 3 * i), 1e-6 * p.dd) << i;
        EXPECT_NEAR(p.sc, covariance(3 * i + 1, 3 * i + 2), 1e-6 * std::sqrt(p.ss * p.cc)) << i;
        EXPECT_NEAR(p.cc, covariance(3 * i + 2, 3 * i + 2), 1e-6 * p.cc) << i;
        if (i == 0) break;
        const Matrix3 gain = backward_gain(filtered[i - 1], feet[i], predicted[i]);
        by = product(gain, {correction[i][0] + by[0], correction[i][1] + by[1], correction[i][2] + by[2]});
        p = smoothed_covariance(filtered[i - 1].covariance, gain, p, predicted[i]);
    }
}

}  // namespace
}  // namespace cmm::fitting
