// SPDX-License-Identifier: Apache-2.0
#include "fitting/circle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "core/text.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double shortest_arc_rad = std::numbers::pi / 3.0;

double squares(std::span<const Vec2> points, const Eigen::Vector3d& circle) {
    double sum = 0.0;
    for (const Vec2& p : points) {
        const double r = (p - circle.head<2>()).norm() - circle[2];
        sum += r * r;
    }
    return sum;
}

/// The full turn less the largest gap between neighbouring polar angles.
double spanned_angle(std::span<const Vec2> points, const Vec2& centre) {
    std::vector<double> angles;
    for (const Vec2& p : points)
        angles.push_back(std::atan2(p.y() - centre.y(), p.x() - centre.x()));
    std::sort(angles.begin(), angles.end());
    double gap = angles.front() + 2.0 * std::numbers::pi - angles.back();
    for (std::size_t i = 1; i < angles.size(); ++i)
        gap = std::max(gap, angles[i] - angles[i - 1]);
    return 2.0 * std::numbers::pi - gap;
}

Eigen::Matrix3d normal_matrix(std::span<const Vec2> points, const Eigen::Vector3d& circle, Eigen::Vector3d& rhs) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    rhs.setZero();
    for (const Vec2& p : points) {
        const Vec2 d = p - circle.head<2>();
        const double distance = std::max(d.norm(), 1e-12);
        const Eigen::Vector3d row(d.x() / distance, d.y() / distance, 1.0);
        normal.noalias() += row * row.transpose();
        rhs += (distance - circle[2]) * row;
    }
    return normal;
}

}  // namespace

core::Result<Circle> fit_circle_kasa(std::span<const Vec2> points) {
    if (points.size() < 3) return core::fail(ErrorCode::fit_not_evaluable, "circle: fewer than 3 points");
    Vec2 mean = Vec2::Zero();
    for (const Vec2& p : points)
        mean += p / static_cast<double>(points.size());
    double scale = 0.0;
    for (const Vec2& p : points)
        scale = std::max(scale, (p - mean).norm());
    if (!(scale > 0.0) || !std::isfinite(scale))
        return core::fail(ErrorCode::fit_not_evaluable, "circle: all points are equal");
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
    for (const Vec2& p : points) {
        const Vec2 q =
            (p - mean) / scale;  // centred and scaled: eq 5's system is badly conditioned far from the origin
        const Eigen::Vector3d row(q.x(), q.y(), 1.0);
        normal.noalias() += row * row.transpose();
        rhs -= q.squaredNorm() * row;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normal);
    if (eigen.eigenvalues()[0] < 1e-12 * eigen.eigenvalues()[2])
        return core::fail(ErrorCode::fit_not_evaluable, "circle: the points are on a line");
    const Eigen::Vector3d abd = normal.ldlt().solve(rhs);
    const Vec2 centre = -0.5 * abd.head<2>();
    Circle circle;
    circle.centre = mean + scale * centre;
    circle.radius = scale * std::sqrt(std::max(0.0, centre.squaredNorm() - abd[2]));
    circle.arc_angle = spanned_angle(points, circle.centre);
    return circle;
}

core::Result<Circle> fit_circle(std::span<const Vec2> points, double sigma_mm) {
    if (points.size() < 5)
        return core::fail(ErrorCode::fit_not_evaluable, "circle: needs 5 points, got " + std::to_string(points.size()));
    const auto start = fit_circle_kasa(points);
    if (!start) return start;
    Eigen::Vector3d circle(start->centre.x(), start->centre.y(), start->radius), rhs;
    double sum = squares(points, circle);
    bool converged = false;
    for (int round = 0; round < 50 && !converged; ++round) {
        const Eigen::Vector3d step = normal_matrix(points, circle, rhs).ldlt().solve(rhs);
        double share = 1.0;
        while (share > 1e-6 && !(squares(points, circle + share * step) <= sum))
            share *= 0.5;
        converged = share <= 1e-6 || step.norm() * share < 1e-10 * circle[2];
        if (share > 1e-6) circle += share * step;
        sum = squares(points, circle);
    }
    if (!converged || !circle.allFinite()) return core::fail(ErrorCode::fit_not_evaluable, "circle: no convergence");

    Circle result;
    result.centre = circle.head<2>();
    result.radius = circle[2];
    result.rms = std::sqrt(sum / static_cast<double>(points.size() - 3));
    result.arc_angle = spanned_angle(points, result.centre);
    if (result.arc_angle < shortest_arc_rad)
        return core::fail(ErrorCode::fit_not_evaluable,
                          "circle: an arc of " + core::fixed(result.arc_angle * 180.0 / std::numbers::pi, 0) +
                              " degrees is too short for a radius (60 degrees)");
    const Eigen::Matrix3d covariance = normal_matrix(points, circle, rhs).inverse();
    result.radius_u95 = 2.0 * std::max(result.rms, sigma_mm) * std::sqrt(covariance(2, 2));
    return result;
}

}  // namespace cmm::fitting
