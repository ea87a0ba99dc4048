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

/// Below it the free form is as near to the points as any model.
inline constexpr double least_noise_mm = 1e-4;
/// Middle part of an edge zone's points that gives a mean circle.
inline constexpr double mean_circle_share = 0.7;

/// What the edges of one section are fitted from: the free-form curve of ball centres, the points that it was fitted
/// to, and the part contour that both edges were found on.
struct EdgeSource {
    const SmoothCurve& smooth;
    std::span<const Vec2> points;
    std::span<const OffsetPoint> part;
    double ball_mm = 0.0;
    Noise noise;
    std::span<const Gap> gaps = {};         ///< of the points
    std::span<const double> leverage = {};  ///< of the points on the curve, where it is not that of `smooth`
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
    /// False: `run` leaves no patch, whatever the points of this edge say. With joints the free form is as good as the
    /// model up to the ends, and it meets the sides where they begin; beyond a gap the sides say nothing of how the
    /// model goes on; without noise no model is nearer to the points.
    bool may_patch(const EdgeRegion& region, const EdgeRegion& other) const;

  private:
    /// The points around an edge, [first, last) by their number along the curve (below 0 and beyond the last: one lap
    /// before and after), and what lies among them.
    struct Surroundings {
        std::ptrdiff_t first = 0, last = 0;
        double shift = 0.0;  // from the curve's parameters to those of the part there
        std::size_t joints = 0;
        bool over_gap = false;
    };
    struct Gathered {
        EdgePoints edge;
        std::vector<double> t;  // of the points, ascending, unwrapped
    };
    Surroundings surroundings(const EdgeRegion& region, const EdgeRegion& other) const;
    bool may_patch(const Surroundings& around) const;
    /// Parameter of the k-th point along the curve, any lap.
    double t_of(std::ptrdiff_t k) const;
    Gathered gather(const EdgeRegion& region, const Surroundings& around) const;
    std::pair<std::size_t, std::size_t> zone_points(const EdgeRegion& region, const Gathered& gathered) const;
    EdgeFit free_form(const EdgeRegion& region, const Gathered& gathered, EdgeAnswer& answer) const;

    EdgeSource source_;
    std::vector<std::size_t> order_;  // of the points by parameter
};

}  // namespace cmm::fitting
