// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A stretch that nobody measured, between two neighbours of a closed sequence of points.
struct Gap {
    std::size_t before = 0, behind = 0;
    double share = 0.0;     ///< of the way round, in a straight line
    double turn_rad = 0.0;  ///< from before it to its chord and on to behind it
    std::size_t bad = 0;    ///< points that were measured there and set aside

    /// Not over an edge, nor over much of the way round: what is beyond goes on from what is before.
    bool on_side() const;
};

/// Of the way round, in one step: over more the points do not tell how the curve goes on, nor which way round it goes.
inline constexpr double most_bridged_share = 0.3;

/// Of the points next to a gap so many may be bad together without anybody beyond to bear witness against them: the
/// contour counts as measured behind them.
inline constexpr std::size_t beside_gap = 4;

/// Where the next point is more than `options.gap_factor` times as far as the points beside are from each other (the
/// median of eight steps, on the side where they lie less densely) and farther than a ball sees from both sides: what
/// scans of a blade leave when something was in the way, or when points were rejected in a row. Also where the ball's
/// way turns round an edge in one step. `points` counter-clockwise.
std::vector<Gap> find_gaps(std::span<const Vec2> points, const SectionOptions& options);

/// What a curve may be supposed to do in the gaps, in their order.
struct Bridges {
    std::vector<GapBridge> over;
    std::string missing;  ///< what was not measured of an edge, or of much of the way round; empty: nothing of that
};

/// A gap on a side: the curve goes on as the eight points on either side do, and turns evenly between. Over an edge,
/// and over more than 30 % of the way round, the nominal lends its way; without one an edge is taken for round where
/// hints say which edge it is. Errors: fit_not_evaluable (nothing tells the way).
core::Result<Bridges> bridges_over(std::span<const Vec2> points, std::span<const Gap> gaps,
                                   const SectionOptions& options);

}  // namespace cmm::fitting
