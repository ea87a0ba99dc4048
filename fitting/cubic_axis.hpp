// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/error.hpp"
#include "fitting/cubic_basis.hpp"

namespace cmm::fitting {

/// One direction of a bicubic surface: cubic B-splines on a knot sequence, each span's four of them as polynomials.
/// Knots as in BSpline: open (clamped or not), controls + 4 of them; or closed, controls + 7, repeating after the
/// period. Immutable value, any thread.
class CubicAxis {
  public:
    /// Value and derivatives by the parameter of the four functions of a span.
    struct Weights {
        Eigen::Array4d value, d1, d2;
    };

    CubicAxis() = default;
    /// Errors: fit_not_evaluable (as BSpline::make).
    static core::Result<CubicAxis> make(std::vector<double> knots, bool closed);
    /// Simple knots on the breaks; closed: breaks cover the period; open: clamped. Errors: as above.
    static core::Result<CubicAxis> on_breaks(const std::vector<double>& breaks, bool closed);

    std::size_t controls() const { return controls_; }
    std::size_t spans() const { return spans_.size(); }
    bool closed() const { return closed_; }
    double front() const { return knots_[3]; }
    double back() const { return knots_[knots_.size() - 4]; }
    const std::vector<double>& knots() const { return knots_; }

    double low(std::size_t span) const { return spans_[span].low; }
    double high(std::size_t span) const { return span + 1 < spans_.size() ? spans_[span + 1].low : back(); }
    /// The control that weighs function 0 of a span; the others follow (closed: round the end).
    std::size_t first(std::size_t span) const { return spans_[span].first; }
    const CubicBasis& basis(std::size_t span) const { return spans_[span].basis; }

    /// t brought into the period, or clamped to the domain; NaN: the front.
    double inside(double t) const;
    /// The span that holds t, which lies inside; the search begins at `near`.
    std::size_t span_of(double t, std::size_t near) const;
    Weights weights(std::size_t span, double t) const;
    /// Mean of the three inner knots under control i: where it pulls (Greville).
    double abscissa(std::size_t control) const;

  private:
    struct Span {
        double low, inverse_width;
        std::size_t first;
        CubicBasis basis;
    };
    std::vector<double> knots_;
    std::vector<Span> spans_;
    std::size_t controls_ = 0;
    bool closed_ = false;
};

}  // namespace cmm::fitting
