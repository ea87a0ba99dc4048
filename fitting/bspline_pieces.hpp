// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/error.hpp"
#include "fitting/bspline.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// The cubic B-spline of a piecewise cubic, closed or clamped. A break becomes a knot of the multiplicity that its
/// continuity asks for: 1 where C2, 2 where C1, 3 where C0; jumps up to `tolerance` times the curve's size count as
/// none. The controls are the values of the pieces' polar forms at three knots (Ramshaw 1989). Errors:
/// fit_not_evaluable (no pieces, the position jumps, a closed curve of fewer than 4 controls).
core::Result<BSpline<2>> to_bspline(const PiecewiseCubic& curve, double tolerance = 1e-9);

/// The polynomial pieces of a cubic B-spline. Errors: fit_not_evaluable (degree not 3).
core::Result<PiecewiseCubic> to_piecewise(const BSpline<2>& curve);

}  // namespace cmm::fitting
