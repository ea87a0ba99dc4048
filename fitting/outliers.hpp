// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/spline_residual.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// What the bad-point search found, per point of the chain.
struct BadPoints {
    std::vector<char> bad;
    std::vector<char> corner;          ///< good points that a corner of the curve had made look bad
    std::vector<double> residual;      ///< by the good neighbours; 0 where a side has fewer than two
    std::vector<double> threshold_mm;  ///< max(floor, local scatter, resolution of the sampling)
    double sigma_mm = 0.0;             ///< standard deviation of a point, from the residuals of the whole chain
    std::size_t count = 0;
};

/// The four-neighbour test made robust (A9): the smallest set of points whose removal makes all others agree with their
/// neighbours, cluster by cluster, worst first. Closed chains wrap; the ends of open ones are not judged.
BadPoints find_bad_points(std::span<const Vec2> points, bool closed, double floor_mm);

}  // namespace cmm::fitting
