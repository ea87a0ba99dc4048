// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>

#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Distance of a point to the cubic through its neighbours.
struct SplineResidual {
    double distance_mm = 0.0;  ///< positive on the right-hand side of the travel
    double gain = 1.0;         ///< standard deviation of the distance / standard deviation of a point
};

/// The distance of `p` to the cubic through two points before (a, b) and two after it (c, d) (seed 000, A8).
SplineResidual spline_residual(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, const Vec2& p);

/// The same of eight points one after another, `first` the first of them, each by its neighbours one and two steps of
/// `by` points away, none of which lies on its own neighbour; in vector lanes, the same to the last bit.
using EightResiduals = std::array<SplineResidual, 8>;
EightResiduals spline_residuals(const Vec2* first, std::ptrdiff_t by);

}  // namespace cmm::fitting
