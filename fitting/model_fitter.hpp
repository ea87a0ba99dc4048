// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <vector>

#include "fitting/edge_model.hpp"
#include "fitting/orthogonal_fit.hpp"
#include "fitting/small_system.hpp"

namespace cmm::fitting {

/// A run of an edge's points.
struct EdgeWindow {
    std::size_t begin = 0, end = 0;
    std::size_t count() const { return end - begin; }
    bool operator==(const EdgeWindow&) const = default;
};

/// Fits one shape at a time to runs of an edge's points, judges it and extends it as far as it pays against the free
/// form. One owner.
class ModelFitter {
  public:
    explicit ModelFitter(const EdgePoints& edge);

    template <class Shape>
    OrthogonalFit<Shape> fit(const Shape& start, const EdgeWindow& w) {
        OrthogonalData data = data_.part(w.begin, w.end);
        if (edge_.noise.freedom > 0.0)
            data.hopeless_squares = hopeless_variances * sigma_ * sigma_ * static_cast<double>(w.count());
        return fit_orthogonal(data, start);
    }

    /// Why the shape, just fitted in the window, cannot be the points'; empty: it can.
    template <class Shape>
    std::string misfit(const OrthogonalFit<Shape>& fitted, const EdgeWindow& w) const {
        if (!fitted.converged && !fitted.hopeless) return "the fit does not converge";
        if (fitted.hopeless || !within_noise(fitted.squares, static_cast<double>(w.count()) - Shape::size))
            return "the points leave it by more than their noise";
        if (follow_each_other(w) || structured(fitted, w)) return "the points leave it systematically";
        return {};
    }

    /// Extends the fit and its window to either side, as far as the model pays.
    template <class Shape>
    void grow(OrthogonalFit<Shape>& best, EdgeWindow& window) {
        constexpr int most_growths = 6;
        double best_gain = gain(best.squares, Shape::size, window);
        const EdgeWindow first = window;
        const auto take_if_better = [&](const EdgeWindow& next) {
            if (next == window) return false;
            const auto fitted = fit(best.shape, next);
            const double next_gain = gain(fitted.squares, Shape::size, next);
            if (!fitted.converged || next_gain <= best_gain) return false;
            best = fitted;
            best_gain = next_gain;
            window = next;
            return true;
        };
        for (int round = 0; round < most_growths; ++round) {
            EdgeWindow next{reach(best, static_cast<std::ptrdiff_t>(first.begin) - 1, -1),
                            reach(best, static_cast<std::ptrdiff_t>(first.end), 1)};
            bool better = take_if_better(next);
            while (!better && !(next == window)) {
                better = take_if_better({next.begin, window.end});
                better = take_if_better({window.begin, next.end}) || better;
                next = {halfway(window.begin, next.begin), halfway(window.end, next.end)};
            }
            if (!better) return;
        }
    }

    /// The Bayesian information criterion of the free form less that of a model, both on the window's points.
    double gain(double squares, int parameters, const EdgeWindow& w) const;
    /// The points about the nose whose normals are within the angle of the nose's.
    EdgeWindow turning_by(double angle_rad) const;
    /// Whether a window goes on along a side: most of the way from the nose to one end has next to no turn.
    bool reaches_a_side(const EdgeWindow& w) const;
    const std::vector<Vec2>& centres() const { return centres_; }
    const EdgePoints& edge() const { return edge_; }
    double ball_mm() const { return edge_.ball_mm; }
    /// The outward normal at a point: of the last fit that reached it, before that of the free form.
    const Vec2& normal(std::size_t i) const { return normals_[i]; }
    void forget_normals();

  private:
    /// From `from` on in one direction, as far as the model pays in all: each further point changes the parameters and
    /// raises the sum of squares as recursive least squares say (Plackett 1950), without a new fit.
    template <class Shape>
    std::size_t reach(const OrthogonalFit<Shape>& fitted, std::ptrdiff_t from, int direction) const {
        constexpr double patience = 8.0;
        using Matrix = typename OrthogonalFit<Shape>::Matrix;
        Matrix inverse = inverse_of_small(fitted.normal);
        typename Shape::Values change = Shape::Values::Zero();
        const auto n = static_cast<std::ptrdiff_t>(centres_.size());
        double sum = 0.0, best = 0.0;
        std::ptrdiff_t end = from;
        for (std::ptrdiff_t i = from; i >= 0 && i < n && sum >= best - patience; i += direction) {
            const auto at = static_cast<std::size_t>(i);
            const auto foot = fitted.shape.foot(centres_[at], normals_[at]);
            const double off = (centres_[at] - foot.position).dot(foot.normal) - edge_.ball_mm;
            const typename Shape::Values weights = inverse * foot.slopes;
            const double innovation = off - foot.slopes.dot(change), spread = 1.0 + foot.slopes.dot(weights);
            change += weights * (innovation / spread);
            inverse.noalias() -= weights * (weights.transpose() / spread);
            sum += free_price(at) - innovation * innovation / (spread * sigma_ * sigma_);
            if (sum > best) {
                best = sum;
                end = i + direction;
            }
        }
        return static_cast<std::size_t>(direction > 0 ? end : end + 1);
    }

    /// Whether harmonics of the normal's direction, of order 2 to 4, would take more off the residuals just left in the
    /// window than noise does (99.9 %): form that the shape lacks.
    template <class Shape>
    bool structured(const OrthogonalFit<Shape>& fitted, const EdgeWindow& w) const {
        constexpr int more = 6;
        static_assert(Shape::size + more <= most_unknowns);
        SmallMatrix normal = SmallMatrix::Zero(Shape::size + more, Shape::size + more);
        SmallVector rhs = SmallVector::Zero(Shape::size + more), row = rhs;
        const Vec2& nose = edge_.points[edge_.nose].normal;
        for (std::size_t i = w.begin; i < w.end; ++i) {
            row.template head<Shape::size>() = fitted.shape.foot(centres_[i], normals_[i]).slopes;
            const Vec2 one(normals_[i].dot(nose), cross(nose, normals_[i]));
            Vec2 turned = one;
            for (int k = 0; k < more; k += 2) {
                turned = Vec2(turned.x() * one.x() - turned.y() * one.y(), turned.x() * one.y() + turned.y() * one.x());
                row[Shape::size + k] = turned.x();
                row[Shape::size + k + 1] = turned.y();
            }
            normal.template selfadjointView<Eigen::Lower>().rankUpdate(row);
            rhs += residuals_[i] * row;
        }
        normal.diagonal() *= 1.0 + 1e-9;  // harmonics that the shape has already
        const double explained = rhs.dot(solve_small(normal, rhs));
        return explained > chi_square_limit(more, 3.09) * sigma_ * sigma_;
    }

    static std::size_t halfway(std::size_t from, std::size_t to) {
        return to > from ? from + (to - from) / 2 : from - (from - to) / 2;
    }
    double free_price(std::size_t i) const {
        const EdgePoint& p = edge_.points[i];
        return p.residual_mm * p.residual_mm / (sigma_ * sigma_) + p.leverage * price_;
    }
    bool within_noise(double squares, double freedom) const;
    bool follow_each_other(const EdgeWindow& w) const;

    static constexpr double hopeless_variances = 6.0;  // Fisher's 99.9 % limit is below it from 4 points on

    const EdgePoints& edge_;
    double sigma_, price_;  // price_: of a parameter
    std::vector<Vec2> centres_, normals_;
    std::vector<double> residuals_;
    OrthogonalData data_;
};

}  // namespace cmm::fitting
