// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "fitting/edge_fit.hpp"
#include "fitting/edges.hpp"
#include "fitting/gaps.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

/// Edges whose own numbers (model, radius, arc) are still to be made: those that the contour does not need.
struct OpenEdges {
    std::vector<OffsetPoint> part;  ///< the part contour that they were found on
    BladeEdges edges;
    std::vector<Gap> gaps;
    double ball_mm = 0.0;
    std::optional<EdgeModel> le_model, te_model;  ///< asked for
    bool le = false, te = false;                  ///< which are open
    std::optional<SmoothCurve> curve = {};  ///< that the contour was made from, where it is not the section's curve
};

/// Of a smoothed curve through that many points.
Noise noise_of(const SmoothCurve& smooth, std::size_t points);

/// Makes them. `smooth`, `good`: the curve of ball centres that `fit`'s contour was made from, and its points.
void fit_open_edges(const OpenEdges& open, const SmoothCurve& smooth, std::span<const Vec2> good, SectionFit& fit);

/// How an edge's numbers answer to the contour's points, by those that lie where its own points are.
void answer_by_contour(const EdgeAnswer& answer, const PiecewiseCubic& curve, std::span<const ContourPoint> contour,
                       EdgeFit& edge);

}  // namespace cmm::fitting
