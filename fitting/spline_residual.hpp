// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Signed distance of `p` to the cubic through two points before (a, b) and two after it (c, d) (seed 000, A8);
/// positive on the right-hand side of the travel.
double spline_residual(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, const Vec2& p);

}  // namespace cmm::fitting
