// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A place on a piecewise curve.
struct CurvePlace {
    std::size_t span = 0;
    double t = 0.0;
};

/// Arc length of a piecewise cubic, both ways, mm. Every span is halved until eight Gauss-Legendre points on a cell and
/// on its halves agree; the whole is exact to 1e-12 unless the curve stops in a cusp.
/// Immutable, any thread.
class ArcLength {
  public:
    ArcLength() = default;
    explicit ArcLength(const PiecewiseCubic& curve);

    double total() const { return cells_.empty() ? 0.0 : cells_.back().s; }
    /// From the curve's start to a place; t inside the span.
    double at(const PiecewiseCubic& curve, const CurvePlace& place) const;
    /// The place at an arc length in [0, total].
    CurvePlace place(const PiecewiseCubic& curve, double s_mm) const;
    /// To the fourth order of a span's length (0.03 um on rows of blades): for those who need a place that hardly
    /// differs from row to row, at a third of the price.
    CurvePlace place_near(double s_mm) const;

  private:
    /// A part of a span: where it starts, and 1 / speed there and at its end for the first guess of `place`.
    struct Cell {
        double t, s, slowness, slowness_end;
        std::size_t span;
    };
    std::size_t cell_of(double s_mm) const;
    CurvePlace place_within(std::size_t cell, double s_mm) const;

    std::vector<Cell> cells_;              // one more at the end
    std::vector<std::size_t> first_cell_;  // of each span; one more at the end
    std::vector<std::size_t> bucket_;      // for equal steps of arc length: the cell where the search begins
    double buckets_per_mm_ = 0.0;
};

}  // namespace cmm::fitting
