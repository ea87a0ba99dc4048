// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A point of a curve: the span, the parameter in it, the squared distance to the asked point.
struct CurveFoot {
    std::size_t span = 0;
    double t = 0.0;
    double squared = 0.0;
};

/// Finds the nearest point of a piecewise cubic, with proof: spans are skipped only when their bounding box is farther
/// away than the best foot so far, and a span is settled by the signs of the Bernstein coefficients of
/// g(w) = (C(w) - p) . C'(w) (docs/theory.md, "Closest point"). The answer is the global minimum to rounding, whatever
/// the hint; a hint only makes it faster. O(log spans) a point near the curve. Immutable, any thread.
class ClosestPointIndex {
  public:
    ClosestPointIndex() = default;
    explicit ClosestPointIndex(const PiecewiseCubic& curve);

    /// For many points near a closed curve whose tangent does not jump: how near a foot must be to be the nearest,
    /// whatever the rest of the curve does, is noted for each span. Takes as long as as many questions as spans.
    void note_clearances();

    /// `hint` is a span near the foot, e.g. that of the point before. A point that is not finite gets the curve's
    /// start and an infinite squared distance.
    CurveFoot closest(const Vec2& point, std::size_t hint = 0) const;

    /// visit(i, foot of points[i]) for all points, in an order in which neighbours follow each other. Eight are
    /// searched at a time, in vector lanes, as long as they share their spans.
    template <class Visit>
    void for_each(std::span<const Vec2> points, Visit&& visit) const {
        const std::vector<std::uint32_t> order = neighbours_first(points);
        const auto place = [&](std::size_t i) { return order.empty() ? i : order[i]; };
        Eight block;
        Trail trail;
        for (std::size_t first = 0; first < points.size(); first += block.size()) {
            const std::size_t count = std::min(block.size(), points.size() - first);
            for (std::size_t k = 0; k < block.size(); ++k)
                block[k] = points[place(first + std::min(k, count - 1))];
            const std::array<CurveFoot, 8> feet = follow(block, trail);
            for (std::size_t k = 0; k < count; ++k)
                visit(place(first + k), feet[k]);
        }
    }

  private:
    using Eight = std::array<Vec2, 8>;
    /// Where the points before had their feet: the last one's span, and how many spans it was from one to the next.
    struct Trail {
        std::size_t span = 0;
        double step = 0.0;
        std::size_t next(std::size_t spans) const;
    };

    /// A span over w in [0, 1] from its own start, and g in Bernstein form: beta_i = constant[i] - q . (vx[i], vy[i]),
    /// where q is the asked point seen from the start.
    struct Leaf {
        std::array<double, 6> constant, vx, vy;
        Vec2 start, b, c, d, end;
        double from, width;
    };
    /// Bounding boxes of neighbours: spans, or groups of the level below.
    static constexpr std::size_t group_size = 8;
    struct Group {
        std::array<double, group_size> low_x, low_y, high_x, high_y;
    };
    struct Best {
        std::size_t leaf;
        double w;
        double squared;
    };
    using Bernstein = std::array<double, 6>;

    /// Empty: they follow each other as they are.
    std::vector<std::uint32_t> neighbours_first(std::span<const Vec2> points) const;
    struct Block;
    std::array<CurveFoot, 8> follow(const Eight& points, Trail& trail) const;
    std::array<CurveFoot, 8> closest(const Eight& points, std::size_t hint) const;
    void search(std::size_t level, std::size_t group, std::size_t skip, Block& block) const;
    void visit(std::size_t leaf, unsigned lanes, Block& block) const;
    CurveFoot foot_of(const Best& best) const;

    bool is_clear(const Best& best) const {
        return !clear_squared_.empty() && best.w > 0.0 && best.w < 1.0 && best.squared < clear_squared_[best.leaf];
    }
    double squared_apart(std::size_t leaf, double most) const;

    void set_box(std::vector<Group>& groups, std::size_t at, const Vec2& low, const Vec2& high) const;
    void search(const Vec2& point, std::size_t level, std::size_t group, std::size_t skip, Best& best) const;
    void visit(const Vec2& point, std::size_t leaf, Best& best) const;
    void solve(const Leaf& span, const Vec2& q, double low, double high, double w, std::size_t leaf, Best& best) const;
    void split(const Leaf& span, const Vec2& q, const Bernstein& beta, double low, double high, std::size_t leaf,
               Best& best) const;

    std::vector<Leaf> leaves_;
    std::vector<std::vector<Group>> levels_;  // levels_[0] holds the boxes of the spans; the last has one or two groups
    std::vector<double> clear_squared_;  // by span, once noted: a foot inside it that is nearer is the nearest of all
};

}  // namespace cmm::fitting
