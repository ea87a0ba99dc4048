// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/arc_length.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// Many points of a curve, column by column, with all that follows from its first two derivatives. The memory is kept
/// from one evaluation to the next; columns have equal length. Units: mm, 1/mm; derivatives by the parameter.
struct CurveSamples {
    std::vector<double> t;
    std::vector<double> x, y;              ///< position
    std::vector<double> dx, dy, ddx, ddy;  ///< first and second derivative
    std::vector<double> nx, ny;            ///< unit right-hand normal: outward when counter-clockwise
    std::vector<double> curvature;         ///< positive where the curve turns left

    std::size_t size() const { return t.size(); }
};

/// At parameters in any order (fastest when ascending: the loop over the points of a span runs in vector lanes).
/// Where the curve stops (first derivative zero) normal and curvature are zero.
void sample_at(const PiecewiseCubic& curve, std::span<const double> t, CurveSamples& samples);

/// At arc lengths in [0, total].
void sample_along(const PiecewiseCubic& curve, const ArcLength& arc, std::span<const double> s_mm,
                  CurveSamples& samples);

}  // namespace cmm::fitting
