// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_conic.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "fitting/edge_starts.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t fewest_conic_points = EllipseShape::size + 4;
constexpr double slope_change = 1e-5;  // of a parameter, mm and rad

}  // namespace

Vec2 EdgeConic::normal(const Vec2& p, const Vec2& near) const {
    return std::visit([&](const auto& shape) { return shape.foot(p, near).normal; }, shape_);
}

double EdgeConic::radius_mm(const Vec2& normal) const {
    return std::visit([&](const auto& shape) { return shape.radius_at(normal); }, shape_);
}

double EdgeConic::direction_variance(const Vec2& p, const Vec2& near) const {
    const auto of_shape = [&](const auto& shape) {
        using Shape = std::decay_t<decltype(shape)>;
        typename Shape::Values slopes;
        for (int k = 0; k < Shape::size; ++k) {
            const typename Shape::Values change = slope_change * Shape::Values::Unit(k);
            const Shape less(shape.values() - change), more(shape.values() + change);
            slopes[k] = turn_angle(less.foot(p, near).normal, more.foot(p, near).normal) / (2.0 * slope_change);
        }
        return slopes.dot(covariance_ * slopes);
    };
    return std::visit([&](const auto& shape) -> double { return of_shape(shape); }, shape_);
}

std::optional<EdgeConic> ConicFitter::fit(const EdgeWindow& window) {
    if (window.end < window.begin + fewest_conic_points) return {};
    const double sigma_mm = edge_.noise.sigma_mm;
    fitter_.forget_normals();
    const auto ellipse = fit_ellipse(window);
    const bool elliptic = ellipse && fitter_.misfit(*ellipse, window).empty();
    fitter_.forget_normals();
    if (const auto start = arc_start(fitter_, window)) {
        const auto arc = fitter_.fit(*start, window);
        const double price = 2.0 * std::log(static_cast<double>(window.count())) * sigma_mm * sigma_mm;
        const bool circular = fitter_.misfit(arc, window).empty();
        if (circular && !(elliptic && arc.squares - ellipse->squares > price)) return EdgeConic(arc, sigma_mm);
    }
    if (elliptic) return EdgeConic(*ellipse, sigma_mm);
    return {};
}

/// The curvature of a conic whose normal has the angle psi to its axis is k^(2/3) = a cos^2 psi + b sin^2 psi: linear
/// in 1, cos 2 phi and sin 2 phi for any direction phi of the normal.
std::optional<EllipseShape> ConicFitter::ellipse_by_curvature(const EdgeWindow& window) const {
    const Vec2 reference = edge_.points[edge_.nose].normal;
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (std::size_t i = window.begin; i < window.end; ++i) {
        if (!(curvature_[i] > 0.0)) continue;
        const double phi = turn_angle(reference, edge_.points[i].normal);
        const Eigen::Vector3d row(1.0, std::cos(2.0 * phi), std::sin(2.0 * phi));
        matrix += row * row.transpose();
        moment += std::cbrt(curvature_[i] * curvature_[i]) * row;
    }
    const Eigen::Vector3d wave = matrix.ldlt().solve(moment);
    const double half = std::hypot(wave[1], wave[2]), along = wave[0] + half;
    if (!(along > 0.0)) return {};
    // Of the two axes the one nearer to the nose.
    double direction = 0.5 * std::atan2(wave[2], wave[1]);
    double at_vertex = along, across = wave[0] - half;
    if (std::abs(direction) > 0.25 * std::numbers::pi) {
        direction -= std::copysign(0.5 * std::numbers::pi, direction);
        std::swap(at_vertex, across);
    }
    if (!(at_vertex > 0.0)) return {};
    const Vec2 axis = std::cos(direction) * reference + std::sin(direction) * left_of(reference);
    const auto vertex = std::max_element(
        edge_.points.begin() + static_cast<std::ptrdiff_t>(window.begin),
        edge_.points.begin() + static_cast<std::ptrdiff_t>(window.end),
        [&](const EdgePoint& a, const EdgePoint& b) { return a.normal.dot(axis) < b.normal.dot(axis); });
    EllipseShape::Values values;
    values << vertex->centre - edge_.ball_mm * vertex->normal, std::atan2(axis.y(), axis.x()),
        std::pow(at_vertex, -1.5), across / at_vertex;
    return EllipseShape(values);
}

std::optional<OrthogonalFit<EllipseShape>> ConicFitter::fit_ellipse(const EdgeWindow& window) {
    if (!last_) last_ = ellipse_by_curvature(window);
    if (!last_) return {};
    const auto fit = fitter_.fit(*last_, window);
    last_ = fit.shape;
    return fit;
}

}  // namespace cmm::fitting
