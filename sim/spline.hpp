// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

/// Cubic splines in the form value and second derivative at the knots, for surfaces of the simulator.
namespace cmm::sim {

using Points = std::vector<Eigen::Vector3d>;

/// Second derivatives of the natural cubic spline through `values` at rising `knots` (same number, two or more).
Points natural_moments(const std::vector<double>& knots, const Points& values);
/// The same for the periodic spline: `knots` has one more than `values`, the last is where the first returns. Three or
/// more.
Points periodic_moments(const std::vector<double>& knots, const Points& values);

/// The weights of value left, value right, moment left, moment right at a place in an interval, with two derivatives.
struct SplineBasis {
    std::array<double, 4> f, d, dd;
};
SplineBasis spline_basis(double left, double right, double at);

/// The interval of `knots` that holds `at` (the first or last one beyond them).
std::size_t spline_interval(const std::vector<double>& knots, double at);

}  // namespace cmm::sim
