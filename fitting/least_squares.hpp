// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/band_solver.hpp"
#include "fitting/cubic_basis.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// Points of a plane curve with their parameters, column by column, sorted by t.
struct PointColumns {
    std::span<const double> t, x, y;
};

/// Normal equations of a cubic B-spline with fixed knots: the Gram matrix of the basis and the moments of the points,
/// summed span by span, then a band factor. Closed: as many controls as spans; open: clamped, spans + 3 controls.
/// Control k + a (round the end when closed) weighs function a of span k. A workspace: `set_knots` keeps the memory,
/// so that one that is used again allocates nothing. One owner, one thread; the same input gives the same bits.
class LeastSquaresSpline {
  public:
    /// Breaks t_0 < ... < t_K, at least 7 spans when closed; forgets all points. Errors: fit_not_evaluable.
    core::Status set_knots(std::span<const double> breaks, bool closed);

    /// Adds the points, with weights (1 / variance) where given. Errors: fit_not_evaluable (columns of different
    /// length, t not ascending or outside [t_0, t_K], also when NaN).
    core::Status add(const PointColumns& points, std::span<const double> weights = {});

    /// A roughness penalty or a constraint may be added here before `solve`.
    BandSolver<3>& normal() { return normal_; }
    std::vector<Vec2>& moments() { return controls_; }

    /// The controls take the place of the moments. Errors: fit_not_evaluable (a span without points that determine it,
    /// values that are not finite).
    core::Status solve();

    const std::vector<Vec2>& controls() const { return controls_; }
    PiecewiseCubic curve() const;

    std::size_t spans() const { return bases_.size(); }
    bool closed() const { return closed_; }
    const CubicBasis& basis(std::size_t span) const { return bases_[span]; }
    /// First point of each span and, at the end, the number of points of the latest `add`.
    std::span<const std::size_t> first_points() const { return first_; }
    /// t_{-3} ... t_{K+3}: over the period when closed, the ends repeated when open.
    std::span<const double> knots() const { return knots_; }

  private:
    double break_at(std::size_t k) const { return knots_[k + 3]; }

    std::vector<double> knots_;
    std::vector<CubicBasis> bases_;
    std::vector<std::size_t> first_;
    BandSolver<3> normal_;
    std::vector<Vec2> controls_;
    bool closed_ = false;
};

/// One fit with a workspace of its own. Errors as above.
core::Result<PiecewiseCubic> fit_fixed_knots(const PointColumns& points, std::span<const double> breaks, bool closed);

}  // namespace cmm::fitting
