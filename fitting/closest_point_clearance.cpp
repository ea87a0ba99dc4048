// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/closest_point.hpp"

/// How near to a curve a point has only one foot that could be the nearest.
namespace cmm::fitting {
namespace {

// Spans to either side that belong to the same arc.
constexpr std::size_t spans_beside = 3;
constexpr double most_arc_turn_rad = 1.5;  // of that arc

/// Bounds of a span's curvature and length.
struct Bend {
    double curvature = 0.0, length_mm = 0.0;
};

Bend bend_of(const Vec2& b, const Vec2& c, const Vec2& d) {
    // The derivative is a mean of these three, its own derivative one of the two below.
    const Vec2 first = b, middle = b + c, last = b + 2.0 * c + 3.0 * d;
    const Vec2 along = (first + middle + last).normalized();
    const double slowest = std::min({first.dot(along), middle.dot(along), last.dot(along)});
    const double fastest = std::max({first.norm(), middle.norm(), last.norm()});
    const double second = std::max((2.0 * c).norm(), (2.0 * c + 6.0 * d).norm());
    if (!(slowest > 0.0)) return {std::numeric_limits<double>::infinity(), fastest};
    return {second / (slowest * slowest), fastest};
}

}  // namespace

/// A foot at distance e is the nearest, first, on the arc about it, when e is less than the radius of curvature
/// anywhere there and the arc turns by less than half a turn to either side: the circle of radius e that touches it
/// there has the arc outside (Schur's comparison with the circle). Second, against all other spans, when they are
/// farther than 2 e from its own.
void ClosestPointIndex::note_clearances() {
    const std::size_t n = leaves_.size();
    clear_squared_.assign(n, 0.0);
    if (n < 2 * spans_beside + 2) return;
    std::vector<Bend> bends;
    bends.reserve(n);
    for (const Leaf& leaf : leaves_)
        bends.push_back(bend_of(leaf.b, leaf.c, leaf.d));
    for (std::size_t k = 0; k < n; ++k) {
        double curvature = 0.0, length = 0.0;
        for (std::size_t j = 0; j <= 2 * spans_beside; ++j) {
            const Bend& bend = bends[(k + n - spans_beside + j) % n];
            curvature = std::max(curvature, bend.curvature);
            length += bend.length_mm;
        }
        if (!(curvature * length < most_arc_turn_rad)) continue;
        // Where the curve is straight, the length of the arc is far enough.
        const double radius = std::min(1.0 / curvature, length);
        clear_squared_[k] = 0.25 * squared_apart(k, 4.0 * radius * radius);
    }
}

/// Squared distance of a span's box from those of all spans that are not beside it, at most `most`.
double ClosestPointIndex::squared_apart(std::size_t leaf, double most) const {
    const std::size_t n = leaves_.size();
    const Group& own = levels_[0][leaf / group_size];
    const std::size_t at = leaf % group_size;
    double best = most;
    const auto look = [&](const auto& again, std::size_t level, std::size_t group) -> void {
        const Group& boxes = levels_[level][group];
        for (std::size_t j = 0; j < group_size; ++j) {
            const double dx = std::max({boxes.low_x[j] - own.high_x[at], own.low_x[at] - boxes.high_x[j], 0.0});
            const double dy = std::max({boxes.low_y[j] - own.high_y[at], own.low_y[at] - boxes.high_y[j], 0.0});
            const double squared = dx * dx + dy * dy;
            if (!(squared < best)) continue;
            const std::size_t index = group_size * group + j;
            if (level > 0) {
                again(again, level - 1, index);
            } else {
                const std::size_t apart = index > leaf ? index - leaf : leaf - index;
                if (std::min(apart, n - apart) > spans_beside) best = squared;
            }
        }
    };
    for (std::size_t group = 0; group < levels_.back().size(); ++group)
        look(look, levels_.size() - 1, group);
    return best;
}

}  // namespace cmm::fitting
