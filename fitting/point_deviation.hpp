// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "fitting/surface.hpp"

namespace cmm::fitting {

/// How far points are from a surface: signed, positive along its normal.
struct SurfaceDeviation {
    double mean_mm = 0.0, rms_mm = 0.0, p95_mm = 0.0, p99_mm = 0.0, max_mm = 0.0;  ///< of magnitudes, but the first
    std::size_t points = 0;
    std::size_t newton_steps = 0;
    std::size_t newton_failures = 0;  ///< no foot found
    std::size_t newton_wrong = 0;     ///< a foot found that is not the nearest
};

/// Newton's method from the foot of the point before (seed 001, B12), or from the surface's middle when `warm` is
/// false; where it fails, or ends more than three times as far away as usual, the nearest foot by SurfaceIndex. So no
/// distance is wrong by more than three times the rms of the others.
SurfaceDeviation deviation_of(const Surface& surface, std::span<const Vec3> points, bool warm = true);

}  // namespace cmm::fitting
