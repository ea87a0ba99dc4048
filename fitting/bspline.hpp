// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "fitting/knots.hpp"

namespace cmm::fitting {

/// A B-spline curve of degree p in Dim coordinates (2: plane; 3: homogeneous plane, see nurbs.hpp).
/// Open: clamped or not, as many controls as basis functions. Closed: n controls used round, knots over p spans more at
/// either end, u_{i+n} = u_i + period; so control i always weighs N_{i,p} with the support [u_i, u_{i+p+1}].
/// Immutable value, any thread.
template <int Dim>
class BSpline {
  public:
    using Point = Eigen::Matrix<double, Dim, 1>;

    /// Errors: fit_not_evaluable (degree outside 1 ... max_degree, knots that descend or are not finite, number of
    /// knots and controls that do not belong together, an empty domain, a closed curve with fewer than p + 1 controls
    /// or knots that are not periodic; controls that are not finite).
    static core::Result<BSpline> make(int degree, std::vector<double> knots, std::vector<Point> controls, bool closed);

    /// De Boor's algorithm; t is brought into the period, or clamped to the domain.
    Point position(double t) const;
    /// Position and derivatives up to `order` <= 3; zero above.
    std::array<Point, 4> derivatives(double t, int order) const;

    /// The same curve with one knot more (Boehm 1980). Errors: fit_not_evaluable (outside the domain, multiplicity
    /// above the degree).
    core::Result<BSpline> with_knot(double t) const;

    struct Removal;
    /// The curve without one occurrence of the inner knot u_r, and a bound of the distance between equal parameters
    /// (Piegl and Tiller 1997, algorithm A5.8 and section 9.4.2). Errors: fit_not_evaluable (not an inner knot, too few
    /// controls).
    core::Result<Removal> without_knot(std::size_t r) const;
    /// Removes knots, cheapest first, as long as the bounds add up to no more than `tolerance` on any span.
    Removal reduced(double tolerance) const;

    /// A closed curve cut open at the start of its domain: clamped, the same shape. An open one gets clamped ends.
    BSpline opened() const;

    int degree() const { return degree_; }
    bool closed() const { return closed_; }
    const std::vector<double>& knots() const { return knots_; }
    const std::vector<Point>& controls() const { return controls_; }
    double front() const { return knots_[static_cast<std::size_t>(degree_)]; }
    double back() const { return knots_[knots_.size() - 1 - static_cast<std::size_t>(degree_)]; }

  private:
    BSpline(int degree, std::vector<double> knots, std::vector<Point> controls, bool closed)
        : degree_(degree), knots_(std::move(knots)), controls_(std::move(controls)), closed_(closed) {}
    /// What is left when knot r goes: the controls that change, from R_{r-p} on, and the one that does not fit.
    struct Local {
        std::array<Point, max_degree + 1> changed;
        std::size_t count = 0, misfit = 0;
        double error = 0.0;
    };
    const Point& control(std::size_t i) const { return controls_[closed_ ? i % controls_.size() : i]; }
    double inside(double t) const;
    std::size_t last_of(std::size_t r) const;
    bool removable(std::size_t r) const;
    Local local_removal(std::size_t r) const;
    BSpline removed(std::size_t r, const Local& local) const;
    BSpline inserted(std::size_t span, double t) const;

    int degree_ = 0;
    std::vector<double> knots_;
    std::vector<Point> controls_;
    bool closed_ = false;
};

template <int Dim>
struct BSpline<Dim>::Removal {
    BSpline curve;
    double error = 0.0;  ///< bound, in the unit of the controls
};

extern template class BSpline<2>;
extern template class BSpline<3>;

}  // namespace cmm::fitting
