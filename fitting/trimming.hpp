// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "fitting/parallel_curve.hpp"

namespace cmm::fitting {

/// A part of a stretch, in its own parameter.
struct StretchPart {
    std::size_t stretch = 0;
    double from = 0.0, to = 0.0;
};

/// Parts that follow each other; a branch ends where the next one crosses it.
using Branch = std::vector<StretchPart>;

/// A closed part of a parallel curve whose points are nowhere nearer to the source than the distance.
struct TrimmedLoop {
    std::vector<Branch> branches;  ///< in order; empty: nothing is left
    bool smooth = false;           ///< a single branch that closes without a corner
};

/// The closed part with the largest area (counter-clockwise; holes do not count). The curve is cut at all crossings;
/// what lies between two of them is wholly valid or wholly not, which the distance to the source decides at a few
/// places.
TrimmedLoop largest_loop(const ParallelCurve& curve);

}  // namespace cmm::fitting
