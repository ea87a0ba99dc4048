// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A parallel curve as a closed cubic spline: C1, broken only in the corners that trimming leaves.
struct OffsetSpline {
    PiecewiseCubic curve;   ///< no pieces: nothing of the source's parallel curve is left
    double error_mm = 0.0;  ///< bound of the distance between this curve and the exact one
};

/// c + d N, where N follows the unit normal as a cubic with its values and derivatives at the ends of each piece, so
/// that the knots are those of c and evenly more between them. The bound is not sampled: N.N - 1 and N.c' are
/// polynomials with double zeros at both ends, u^2 (1-u)^2 q(u) with q of degree 2 and 1, whose extremes are known.
/// Trimmed like offset_curve; a corner of c is rounded where the parallel curve would gape.
OffsetSpline offset_spline(const PiecewiseCubic& source, double distance_mm, double tolerance_mm);

}  // namespace cmm::fitting
