// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A stretch that nobody measured, between two neighbours of a closed sequence of points.
struct Gap {
    std::size_t before = 0, behind = 0;
};

/// Of the points next to a gap so many may be bad together without anybody beyond to bear witness against them: the
/// contour counts as measured behind them.
inline constexpr std::size_t beside_gap = 4;

/// Where the next point is more than `options.gap_factor` times as far as the points beside are from each other (the
/// median of eight steps, on the side where they lie less densely) and farther than a ball sees from both sides: what
/// scans of a blade leave when something was in the way, or when points were rejected in a row. Also where the ball's
/// way turns round an edge in one step. `points` counter-clockwise.
std::vector<Gap> find_gaps(std::span<const Vec2> points, const SectionOptions& options);

/// What a curve may be supposed to do in each gap: go on as the eight points on either side do, and turn evenly
/// between.
std::vector<GapBridge> bridges_over(std::span<const Vec2> points, std::span<const Gap> gaps);

/// Whether a curve may bridge the gaps: on the sides of a blade it may, but nothing tells the way round an edge.
/// Errors: fit_not_evaluable (a gap that is too wide, or in which the points turn too far).
core::Status check_bridges(std::span<const Vec2> points, std::span<const Gap> gaps);

}  // namespace cmm::fitting
