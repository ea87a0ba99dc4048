// SPDX-License-Identifier: Apache-2.0
#include "acquisition/cubic_spline.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::acquisition {
namespace {

using Vectors = std::vector<Eigen::Vector3d>;

/// Thomas algorithm; the system is diagonally dominant, so no pivoting. Works on any right-hand side with scalar
/// factors.
template <class Value>
std::vector<Value> solve_tridiagonal(const std::vector<double>& lower, std::vector<double> diagonal,
                                     const std::vector<double>& upper, std::vector<Value> rhs) {
    const std::size_t n = rhs.size();
    for (std::size_t i = 1; i < n; ++i) {
        const double factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        rhs[i] -= factor * rhs[i - 1];
    }
    rhs[n - 1] /= diagonal[n - 1];
    for (std::size_t i = n - 1; i-- > 0;)
        rhs[i] = (rhs[i] - upper[i] * rhs[i + 1]) / diagonal[i];
    return rhs;
}

/// Second divided difference times 6: the right-hand side of the moment equations at a knot.
Eigen::Vector3d bend(const Eigen::Vector3d& before, const Eigen::Vector3d& at, const Eigen::Vector3d& after,
                     double width_before, double width_after) {
    return 6.0 * ((after - at) / width_after - (at - before) / width_before);
}

}  // namespace

CubicSpline CubicSpline::periodic(std::vector<double> knots, Vectors points) {
    const std::size_t n = points.size();
    std::vector<double> h(n), lower(n), diagonal(n), upper(n);
    for (std::size_t i = 0; i < n; ++i)
        h[i] = knots[i + 1] - knots[i];
    Vectors rhs(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t previous = (i + n - 1) % n;
        lower[i] = h[previous];
        diagonal[i] = 2.0 * (h[previous] + h[i]);
        upper[i] = h[i];
        rhs[i] = bend(points[previous], points[i], points[(i + 1) % n], h[previous], h[i]);
    }
    // Sherman and Morrison: the two corners are a rank-one change of a tridiagonal matrix.
    const double corner_top = lower[0], corner_bottom = upper[n - 1], gamma = -diagonal[0];
    diagonal[0] -= gamma;
    diagonal[n - 1] -= corner_top * corner_bottom / gamma;
    std::vector<double> column(n, 0.0);
    column[0] = gamma;
    column[n - 1] = corner_bottom;
    Vectors moments = solve_tridiagonal(lower, diagonal, upper, std::move(rhs));
    const auto z = solve_tridiagonal(lower, diagonal, upper, std::move(column));
    const double ratio = corner_top / gamma;
    const Eigen::Vector3d factor = (moments[0] + ratio * moments[n - 1]) / (1.0 + z[0] + ratio * z[n - 1]);
    for (std::size_t i = 0; i < n; ++i)
        moments[i] -= z[i] * factor;

    CubicSpline spline;
    points.push_back(points.front());
    moments.push_back(moments.front());
    spline.knots_ = std::move(knots);
    spline.points_ = std::move(points);
    spline.moments_ = std::move(moments);
    spline.closed_ = true;
    return spline;
}

CubicSpline CubicSpline::natural(std::vector<double> knots, Vectors points) {
    const std::size_t n = points.size();
    CubicSpline spline;
    spline.moments_.assign(n, Eigen::Vector3d::Zero());
    if (n > 2) {
        std::vector<double> lower(n - 2), diagonal(n - 2), upper(n - 2);
        Vectors rhs(n - 2);
        for (std::size_t i = 1; i + 1 < n; ++i) {
            const double before = knots[i] - knots[i - 1], after = knots[i + 1] - knots[i];
            lower[i - 1] = before;
            diagonal[i - 1] = 2.0 * (before + after);
            upper[i - 1] = after;
            rhs[i - 1] = bend(points[i - 1], points[i], points[i + 1], before, after);
        }
        const Vectors inner = solve_tridiagonal(lower, diagonal, upper, std::move(rhs));
        std::copy(inner.begin(), inner.end(), spline.moments_.begin() + 1);
    }
    spline.knots_ = std::move(knots);
    spline.points_ = std::move(points);
    return spline;
}

CubicSpline::Place CubicSpline::place(double t) const {
    if (closed_) {
        const double period = knots_.back() - knots_.front();
        t -= period * std::floor((t - knots_.front()) / period);
    }
    const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t);
    const auto span = static_cast<std::size_t>(after - knots_.begin()) - 1;
    const double width = knots_[span + 1] - knots_[span];
    return {span, width, t - knots_[span], knots_[span + 1] - t};
}

Eigen::Vector3d CubicSpline::value(double t) const {
    const auto [i, h, a, b] = place(t);
    return (moments_[i] * (b * b * b) + moments_[i + 1] * (a * a * a)) / (6.0 * h) +
           (points_[i] / h - moments_[i] * (h / 6.0)) * b + (points_[i + 1] / h - moments_[i + 1] * (h / 6.0)) * a;
}

Eigen::Vector3d CubicSpline::first(double t) const {
    const auto [i, h, a, b] = place(t);
    return (moments_[i + 1] * (a * a) - moments_[i] * (b * b)) / (2.0 * h) + (points_[i + 1] - points_[i]) / h -
           (moments_[i + 1] - moments_[i]) * (h / 6.0);
}

Eigen::Vector3d CubicSpline::second(double t) const {
    const auto [i, h, a, b] = place(t);
    return (moments_[i] * b + moments_[i + 1] * a) / h;
}

}  // namespace cmm::acquisition
