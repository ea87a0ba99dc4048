// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>

#include "fitting/surface.hpp"

namespace cmm::fitting {

/// The point of a surface that is nearest to an asked point.
struct SurfaceFoot {
    SurfacePlace place;
    double squared = 0.0;  ///< of the distance, mm^2
};

/// What a search took.
struct SearchCost {
    std::size_t steps = 0;     ///< of Newton's method
    std::size_t failures = 0;  ///< Newton's method did not converge from its start
    std::size_t wrong = 0;     ///< it did, to a place that is not the nearest
    std::size_t split = 0;     ///< patches that had to be split for the proof
};

/// Spans of a surface's axes near which to look for those that hold a place.
struct SurfaceSpans {
    std::size_t u = 0, v = 0;
};

/// Newton's method for the foot of p from a start (seed 001, B12: g = (S_u.r, S_v.r) = 0 with the second derivatives in
/// the matrix; the first fundamental form instead where that is not positive definite), clamped to the domain. None:
/// not converged within 20 steps. `near` becomes where it ended.
std::optional<SurfaceFoot> newton_foot(const Surface& surface, const Vec3& p, const SurfacePlace& start,
                                       SurfaceSpans& near, SearchCost* cost = nullptr);

}  // namespace cmm::fitting
