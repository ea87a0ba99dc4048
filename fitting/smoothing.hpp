// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A closed least-squares cubic spline through noisy points (docs/theory.md, "The centre curve").
struct SmoothCurve {
    PiecewiseCubic curve;
    std::vector<double> parameter;  ///< of each input point on `curve`
    std::vector<double> residual;   ///< signed, along the right-hand normal (outward when counter-clockwise)
    std::vector<double> leverage;   ///< per span: mean variance of the curve / variance of a point
};

/// Fits points that go round once, in order. Knots are added where the residuals are not white noise of standard
/// deviation `sigma_mm`, so that their density follows the curvature and the smoothing follows the noise. No knot
/// interval holds fewer than `least_per_span` points (3: fewer where the misfit is gross); more of them make a stiffer
/// curve, from which bad points stand out. O(n). Errors: fit_not_evaluable (fewer than 12 points, singular).
core::Result<SmoothCurve> smooth_closed(std::span<const Vec2> points, double sigma_mm, std::size_t least_per_span = 3);

}  // namespace cmm::fitting
