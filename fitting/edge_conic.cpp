// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_conic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "fitting/edge_starts.hpp"

namespace cmm::fitting {
namespace {

// From a circle about the nose on, whose ellipse is farther from it the more of it is seen.
constexpr std::array growing_turns_rad{0.9, 1.1, 1.25, 1.4};
constexpr std::size_t fewest_points = EllipseShape::size + 4;
constexpr int most_fits = 5;           // of a window: one is given up after some rounds
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
    if (window.end < window.begin + fewest_points) return {};
    fitter_.forget_normals();
    const auto ellipse = fit_ellipse(window);
    const bool elliptic = ellipse && fitter_.misfit(*ellipse, window).empty();
    fitter_.forget_normals();
    if (const auto start = arc_start(fitter_, window)) {
        const auto arc = fitter_.fit(*start, window);
        const double price = 2.0 * std::log(static_cast<double>(window.count())) * sigma_mm_ * sigma_mm_;
        const bool circular = fitter_.misfit(arc, window).empty();
        if (circular && !(elliptic && arc.squares - ellipse->squares > price)) return EdgeConic(arc, sigma_mm_);
    }
    if (elliptic) return EdgeConic(*ellipse, sigma_mm_);
    return {};
}

std::optional<OrthogonalFit<EllipseShape>> ConicFitter::fit_ellipse(const EdgeWindow& window) {
    if (!last_) {
        for (const double turn : growing_turns_rad) {
            const EdgeWindow near = fitter_.turning_by(turn);
            const EdgeWindow inner{std::max(window.begin, near.begin), std::min(window.end, near.end)};
            if (inner.end < inner.begin + fewest_points) return {};
            const auto start = last_ ? last_ : round_start(fitter_, inner);
            if (!start) return {};
            last_ = settled(*start, inner).shape;
        }
        fitter_.forget_normals();
    }
    const auto fit = settled(*last_, window);
    last_ = fit.shape;
    return fit;
}

OrthogonalFit<EllipseShape> ConicFitter::settled(const EllipseShape& start, const EdgeWindow& window) {
    auto fit = fitter_.fit(start, window);
    for (int again = 1; again < most_fits && !fit.converged; ++again)
        fit = fitter_.fit(fit.shape, window);
    return fit;
}

}  // namespace cmm::fitting
