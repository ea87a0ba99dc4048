// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fitting/outliers.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Finds runs of two to four bad points that agree with one another, so that each excuses the next in the 4-neighbour
/// test (seed 000, A8; the gap A9): a quartic through seven good neighbours on each side, which fits those neighbours
/// closely, passes them all on the same side at a distance. Where the quartic does not fit (a kink, coarse texture)
/// nothing is said. `points` in lap order; marks `found.bad`, `found.residual` and clears `found.corner`. Returns how
/// many were marked.
std::size_t mark_bad_runs(std::span<const Vec2> points, bool closed, double floor_mm, BadPoints& found);

}  // namespace cmm::fitting
