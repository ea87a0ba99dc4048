// SPDX-License-Identifier: Apache-2.0
#include "sim/spline.hpp"

#include <algorithm>

namespace cmm::sim {

namespace {

/// A tridiagonal system by elimination without exchange: splines' systems are diagonally dominant.
template <class Value>
std::vector<Value> solve_tridiagonal(const std::vector<double>& lower, std::vector<double> diagonal,
                                     const std::vector<double>& upper, std::vector<Value> right) {
    const std::size_t n = diagonal.size();
    for (std::size_t i = 1; i < n; ++i) {
        const double factor = lower[i] / diagonal[i - 1];
        diagonal[i] -= factor * upper[i - 1];
        right[i] -= factor * right[i - 1];
    }
    for (std::size_t i = n; i-- > 0;) {
        if (i + 1 < n) right[i] -= upper[i] * right[i + 1];
        right[i] /= diagonal[i];
    }
    return right;
}

}  // namespace

Points natural_moments(const std::vector<double>& knots, const Points& values) {
    const std::size_t n = values.size();
    std::vector<double> lower(n, 0.0), diagonal(n, 1.0), upper(n, 0.0);
    Points right(n, Eigen::Vector3d::Zero());
    for (std::size_t i = 1; i + 1 < n; ++i) {
        const double before = knots[i] - knots[i - 1], after = knots[i + 1] - knots[i];
        lower[i] = before / 6.0;
        diagonal[i] = (before + after) / 3.0;
        upper[i] = after / 6.0;
        right[i] = (values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before;
    }
    return solve_tridiagonal(lower, diagonal, upper, right);
}

Points periodic_moments(const std::vector<double>& knots, const Points& values) {
    const std::size_t n = values.size();
    std::vector<double> lower(n), diagonal(n), upper(n);
    Points right(n);
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t last = (i + n - 1) % n;
        const double before = knots[last + 1] - knots[last], after = knots[i + 1] - knots[i];
        lower[i] = before / 6.0;
        diagonal[i] = (before + after) / 3.0;
        upper[i] = after / 6.0;
        right[i] = (values[(i + 1) % n] - values[i]) / after - (values[i] - values[last]) / before;
    }
    // The two corner elements by the Sherman-Morrison formula: A = T + w z^T with w = (g, 0 ... upper), z = (1, 0 ...
    // lower/g).
    const double corner_low = lower[0], corner_up = upper[n - 1], g = -diagonal[0];
    diagonal[0] -= g;
    diagonal[n - 1] -= corner_low * corner_up / g;
    std::vector<double> w(n, 0.0);
    w[0] = g;
    w[n - 1] = corner_up;
    Points x = solve_tridiagonal(lower, diagonal, upper, right);
    const std::vector<double> y = solve_tridiagonal(lower, diagonal, upper, w);
    const Eigen::Vector3d factor = (x[0] + corner_low / g * x[n - 1]) / (1.0 + y[0] + corner_low / g * y[n - 1]);
    for (std::size_t i = 0; i < n; ++i)
        x[i] -= y[i] * factor;
    return x;
}

SplineBasis spline_basis(double left, double right, double at) {
    const double h = right - left, a = (right - at) / h, b = (at - left) / h;
    return {{a, b, (a * a * a - a) * h * h / 6.0, (b * b * b - b) * h * h / 6.0},
            {-1.0 / h, 1.0 / h, -(3.0 * a * a - 1.0) * h / 6.0, (3.0 * b * b - 1.0) * h / 6.0},
            {0.0, 0.0, a, b}};
}

std::size_t spline_interval(const std::vector<double>& knots, double at) {
    const auto above = std::upper_bound(knots.begin() + 1, knots.end() - 1, at);
    return static_cast<std::size_t>(above - knots.begin()) - 1;
}

}  // namespace cmm::sim
