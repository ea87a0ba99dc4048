// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

#include "fitting/outliers.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Judges anew the points between `before` and `behind`, good ones of a closed chain with a gap between them over which
/// no side goes: what lies beyond such a gap bears no witness, and accuses wrongly. Each of them is heard by the good
/// points of its own stretch, and free where those tell nothing. `found` (of find_bad_points, with the same
/// `floor_mm`) takes verdicts, residuals and thresholds. False when no verdict changes.
bool judge_ends(std::span<const Vec2> points, std::size_t before, std::size_t behind, double floor_mm,
                BadPoints& found);

}  // namespace cmm::fitting
