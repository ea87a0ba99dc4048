// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

namespace cmm::acquisition {

/// A C2 cubic spline through points in space over given knots. Immutable value, thread-safe.
class CubicSpline {
  public:
    CubicSpline() = default;
    /// Closed: `knots` has one entry more than `points` (the period's end). At least 3 points, knots increasing.
    static CubicSpline periodic(std::vector<double> knots, std::vector<Eigen::Vector3d> points);
    /// Open, second derivative zero at the ends; two points give a straight line. As many knots as points, increasing.
    static CubicSpline natural(std::vector<double> knots, std::vector<Eigen::Vector3d> points);

    Eigen::Vector3d value(double t) const;
    Eigen::Vector3d first(double t) const;
    Eigen::Vector3d second(double t) const;
    const std::vector<double>& knots() const { return knots_; }

  private:
    /// Span index, parameter brought into the period, and the parts left (a) and right (b) of it.
    struct Place {
        std::size_t span;
        double width, a, b;
    };
    Place place(double t) const;

    std::vector<double> knots_;
    std::vector<Eigen::Vector3d> points_, moments_;  // moments: second derivatives at the knots; closed: first repeated
    bool closed_ = false;
};

}  // namespace cmm::acquisition
