// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/band_solver.hpp"
#include "fitting/cubic_axis.hpp"
#include "fitting/surface.hpp"

namespace cmm::fitting {

/// Cubic splines of v through columns of points, one at each row's v, that change their third derivative no more than
/// the weight allows (Eilers and Marx 1996, with the jumps of the third derivative as differences, so that cubics cost
/// nothing): sum |S(v_k) - y_k|^2 + weight sum |jump_j h^3|^2, h the mean distance of the rows. The matrix is the same
/// for all columns and factored once.
class ColumnSmoother {
  public:
    /// Knots on the inner rows; the ends lie `beyond` outside the first and the last row. At least 2 rows, ascending
    /// (checked by the caller). With 2 or 3 rows the spline that bends least.
    ColumnSmoother(std::span<const double> rows, double beyond);

    const CubicAxis& axis() const { return axis_; }
    /// False when the system is singular.
    bool set_weight(double weight);
    /// Sum of the leverages: effective number of parameters.
    double freedom() const { return freedom_; }
    /// Share that row k has in the spline there.
    double leverage(std::size_t row) const { return leverage_[row]; }
    /// The controls for a column of as many points as rows; a point is a vector, or an array of several columns'
    /// points.
    template <class Point>
    void solve(const std::vector<Point>& column, std::vector<Point>& controls) const {
        controls.assign(axis_.controls(), Point::Zero());
        for (std::size_t k = 0; k < places_.size(); ++k)
            for (int a = 0; a < 4; ++a)
                controls[places_[k].span + static_cast<std::size_t>(a)] += places_[k].weights[a] * column[k];
        normal_.solve(std::span(controls));
    }
    /// The spline at row k.
    template <class Point>
    Point at_row(std::size_t row, const std::vector<Point>& controls) const {
        Point sum = Point::Zero();
        for (int a = 0; a < 4; ++a)
            sum += places_[row].weights[a] * controls[places_[row].span + static_cast<std::size_t>(a)];
        return sum;
    }

  private:
    struct Place {
        std::size_t span;
        Eigen::Array4d weights;
    };
    CubicAxis axis_;
    std::vector<Place> places_;
    double spacing_ = 1.0;
    BandSolver<4> normal_;
    std::vector<BandSolver<4>::Row> inverse_;
    std::vector<double> leverage_;
    double freedom_ = 0.0;
};

}  // namespace cmm::fitting
