// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/section.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Input indices in the order of one lap, counter-clockwise. The first one does not depend on where the scan began (it
/// is the good point farthest from the middle), so neither do the results.
struct Lap {
    std::vector<std::size_t> index;
    std::vector<std::size_t>
        again;  ///< a second measurement of a stretch (past the start, after a step back): not in `index`
    bool was_clockwise = false;
};

/// Keeps the points that are finite, wanted and not repeated; `duplicate[i]` says which lie on or right beside (2 % of
/// the median spacing) their predecessor.
std::vector<std::size_t> usable_points(std::span<const Vec2> points, std::span<const char> excluded,
                                       std::vector<char>& duplicate);

/// Closes the chain `points[usable]`: finds where it passes its start, sets the overlap aside, and turns the
/// lap counter-clockwise. Bad points are tolerated (they are set aside by the open-chain test first) and keep their
/// place in the lap. Its ends may be apart: that is a gap like others. Where they are far apart, the nominal of
/// `options` says which way round is counter-clockwise; without one the area does. Errors: fit_not_evaluable (too few
/// points, no area).
core::Result<Lap> order_lap(std::span<const Vec2> points, const std::vector<std::size_t>& usable,
                            const SectionOptions& options);

/// Puts the points of a later pass, which lie between those of the lap, where they belong in it: at their feet on the
/// polygon through its good points, in a gap as they follow each other. One on the spot of its neighbour (1 nm) goes to
/// `again`.
void join_pass(std::span<const Vec2> points, const std::vector<std::size_t>& later, double reject_floor_mm, Lap& lap);

}  // namespace cmm::fitting
