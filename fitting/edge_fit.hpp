// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fitting/edges.hpp"
#include "fitting/gaps.hpp"
#include "fitting/join.hpp"
#include "fitting/section.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {

/// What the edges of one section are fitted from: the free-form curve of ball centres, the points that it was fitted
/// to, and the part contour that both edges were found on.
struct EdgeSource {
    const SmoothCurve& smooth;
    std::span<const Vec2> points;
    std::span<const OffsetPoint> part;
    double ball_mm = 0.0;
    Noise noise;
    std::span<const Gap> gaps = {};  ///< of the points
};

/// How centre x, centre y and radius answer to the displacements of the edge's points outwards along their normals.
struct EdgeAnswer {
    std::vector<double> t;  ///< of the points, on the curve; empty: there is no radius
    Eigen::Matrix<double, 3, Eigen::Dynamic> by_point;
};

struct EdgeOutcome {
    EdgeFit fit;
    EdgeAnswer answer;
    std::optional<EdgePatch> patch;  ///< of the curve of ball centres, where the points support a model
};

/// Fits and judges edges of a section. One owner; the source must outlive it.
class EdgeFitter {
  public:
    explicit EdgeFitter(const EdgeSource& source);
    /// One edge; `other` bounds its surroundings.
    EdgeOutcome run(const EdgeRegion& region, const EdgeRegion& other, std::optional<EdgeModel> request) const;

  private:
    struct Gathered {
        EdgePoints edge;
        std::vector<double> t;  // of the points, ascending, unwrapped
        bool over_gap = false;
    };
    Gathered gather(const EdgeRegion& region, const EdgeRegion& other) const;
    std::pair<std::size_t, std::size_t> zone_points(const EdgeRegion& region, const Gathered& gathered) const;
    EdgeFit free_form(const EdgeRegion& region, const Gathered& gathered, EdgeAnswer& answer) const;

    EdgeSource source_;
    std::vector<std::size_t> order_;  // of the points by parameter
};

}  // namespace cmm::fitting
