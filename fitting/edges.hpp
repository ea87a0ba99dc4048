// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/offset.hpp"
#include "fitting/section.hpp"

namespace cmm::fitting {

/// A leading or trailing edge on a closed counter-clockwise contour, as indices of its points.
struct EdgeRegion {
    std::size_t begin = 0,
                end = 0;      ///< transition points; the region runs from begin on to end, over the wrap if need be
    std::size_t middle = 0;   ///< of its sharpest 120 degrees
    std::size_t nose = 0;     ///< where the normal halves the angle between the two sides: that point ...
    double nose_share = 0.0;  ///< ... or exactly, by so much of the step from the point before, before it
    double scale_mm = 0.0;    ///< length over turn of its sharpest 120 degrees: the radius of a circular edge
};

/// The four zones of a contour.
struct BladeEdges {
    EdgeRegion le, te;
    bool suction_after_le = true;  ///< counter-clockwise from the LE comes the suction side
};

/// Finds both edges as the shortest arcs that turn by 120 degrees, their transitions where the curvature drops to 0.4
/// of the edge's, which one leads (hints, otherwise the larger scale) and which side the camber bulges to. Errors:
/// fit_not_evaluable (no two edges).
core::Result<BladeEdges> find_edges(std::span<const OffsetPoint> contour, const std::optional<Vec2>& le_hint,
                                    const std::optional<Vec2>& te_hint);

/// Exactly where the nose is, not only which point is next to it.
Vec2 nose_of(const EdgeRegion& region, std::span<const OffsetPoint> contour);

/// Whether index i lies in the region.
bool holds(const EdgeRegion& region, std::size_t i);

/// The zone of each of `count` contour points.
std::vector<Zone> zones_of(const BladeEdges& edges, std::size_t count);

}  // namespace cmm::fitting
