// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "fitting/edge_shapes.hpp"
#include "fitting/small_system.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Ball centres (ball 0: points of the part) on one arc, and what a fit leaves behind at each.
struct OrthogonalData {
    std::span<const Vec2> points;
    std::span<Vec2> normals;      ///< in: outward unit normals as far as they are known; out: those of the feet
    std::span<double> residuals;  ///< out: |p - foot| - ball, signed, mm
    double ball_mm = 0.0;
    /// A sum of squares above this that has nearly stopped falling is not worth more rounds: the fit ends, hopeless.
    double hopeless_squares = std::numeric_limits<double>::infinity();

    OrthogonalData part(std::size_t begin, std::size_t end) const {
        const std::size_t n = end - begin;
        return {points.subspan(begin, n), normals.subspan(begin, n), residuals.subspan(begin, n), ball_mm,
                hopeless_squares};
    }
};

/// The least-squares sums of a shape at the points.
template <class Shape>
struct OrthogonalSums {
    Eigen::Matrix<double, Shape::size, Shape::size> matrix;
    Eigen::Matrix<double, Shape::size, 1> rhs;
    double squares = 0.0;

    OrthogonalSums(const Shape& shape, const OrthogonalData& data) {
        matrix.setZero();
        rhs.setZero();
        std::size_t i = 0;
        if constexpr (requires(typename Shape::Foot * feet) { shape.feet(&data.points[0], &data.normals[0], feet); }) {
            std::array<typename Shape::Foot, foot_lanes> feet;
            for (; i + foot_lanes <= data.points.size(); i += foot_lanes) {
                shape.feet(&data.points[i], &data.normals[i], feet.data());
                for (std::size_t k = 0; k < feet.size(); ++k)
                    add(data, i + k, feet[k]);
            }
        }
        for (; i < data.points.size(); ++i)
            add(data, i, shape.foot(data.points[i], data.normals[i]));
        matrix.template triangularView<Eigen::StrictlyUpper>() = matrix.transpose();
    }

  private:
    void add(const OrthogonalData& data, std::size_t i, const typename Shape::Foot& foot) {
        const double residual = (data.points[i] - foot.position).dot(foot.normal) - data.ball_mm;
        data.normals[i] = foot.normal;
        data.residuals[i] = residual;
        for (int k = 0; k < Shape::size; ++k) {
            for (int j = 0; j <= k; ++j)
                matrix(k, j) += foot.slopes[k] * foot.slopes[j];
            rhs[k] += residual * foot.slopes[k];
        }
        squares += residual * residual;
    }
};

/// A shape through the points and the equations that it solves.
template <class Shape>
struct OrthogonalFit {
    using Matrix = Eigen::Matrix<double, Shape::size, Shape::size>;
    Shape shape;
    double squares = std::numeric_limits<double>::infinity();  ///< sum of squared residuals, mm^2
    Matrix normal = Matrix::Zero();                            ///< inverse covariance at unit variance
    bool converged = false;
    bool hopeless = false;
};

/// Minimises the sum of squared residuals over the shape's parameters, by the method of Levenberg 1944 and Marquardt
/// 1963. The first two parameters are a place: they are damped and measured together, so that no step depends on where
/// the axes point. The slope of an orthogonal distance is that of the foot, held at its place on the shape, along the
/// normal, because the distance is stationary there (Ahn 2004, "Least Squares Orthogonal Distance Fitting", 2.3).
template <class Shape>
OrthogonalFit<Shape> fit_orthogonal(const OrthogonalData& data, const Shape& start) {
    constexpr int most_rounds = 15;
    constexpr double last_step = 1e-7;      // mm and rad: what then is missing is some powers of ten smaller
    constexpr double still = 1e-6;          // of the sum of squares
    constexpr double hopeless_gain = 0.05;  // of the sum of squares, in a round
    constexpr int last_rounds = 2;
    constexpr double longest_last_step = 1e-2;  // mm and rad: farther, the undamped step is not trusted
    OrthogonalFit<Shape> fit{start};
    if (!start.valid()) return fit;
    using Values = typename Shape::Values;
    const auto longest = [](const Values& step) {
        return std::max(step.template head<2>().norm(), step.template tail<Shape::size - 2>().cwiseAbs().maxCoeff());
    };
    OrthogonalSums<Shape> now(start, data);
    double damping = 1e-4;
    bool current = true;  // the residuals are those of fit.shape
    for (int round = 0; round < most_rounds && !fit.converged && !fit.hopeless && damping < 1e8; ++round) {
        Values diagonal = now.matrix.diagonal();
        diagonal.template head<2>().setConstant(0.5 * (diagonal[0] + diagonal[1]));
        auto damped = now.matrix;
        damped.diagonal() += damping * diagonal;
        damped.diagonal().array() += 1e-12 * diagonal.maxCoeff();
        const Values step = solve_small(damped, now.rhs);
        const bool small = longest(step) <= last_step;
        if (const Shape next(fit.shape.values() + step); next.valid()) {
            const OrthogonalSums<Shape> then(next, data);
            current = then.squares <= now.squares;
            if (current) {
                const double gain = now.squares - then.squares;
                fit.converged = damping < 1e-2 && (small || gain <= still * now.squares);
                fit.hopeless = then.squares > data.hopeless_squares && gain <= hopeless_gain * now.squares;
                fit.shape = next;
                now = then;
                damping *= 0.1;
                continue;
            }
        }
        fit.converged = small;
        damping *= 10.0;
    }
    if (!current) now = OrthogonalSums<Shape>(fit.shape, data);
    // At the minimum the sums differ by rounding only and cannot judge a step any more: the last steps are not asked.
    for (int round = 0; round < last_rounds && fit.converged && !fit.hopeless; ++round) {
        const Values step = solve_small(now.matrix, now.rhs);
        const Shape next(fit.shape.values() + step);
        if (!next.valid() || !(longest(step) < longest_last_step)) break;
        fit.shape = next;
        now = OrthogonalSums<Shape>(fit.shape, data);
    }
    fit.squares = now.squares;
    fit.normal = now.matrix;
    return fit;
}

}  // namespace cmm::fitting
