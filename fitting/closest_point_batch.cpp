// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <limits>

#include "fitting/bernstein_signs.hpp"
#include "fitting/closest_point.hpp"

/// The search of closest_point.cpp for eight points at a time: the same proof, the arithmetic in vector lanes.
namespace cmm::fitting {
namespace {

using Lanes = Eigen::Array<double, 8, 1>;
constexpr double infinity = std::numeric_limits<double>::infinity();
// Beyond this the squares overflow.
constexpr double too_far = 1e150;
// Fewer points than this are better served one by one.
constexpr int worth_a_block = 3;
// Points that are farther apart than this, in spans, hardly share any.
constexpr double farthest_in_a_block = 0.5;

}  // namespace

struct ClosestPointIndex::Block {
    const Eight& points;
    Lanes x, y, squared = Lanes::Constant(infinity);
    std::array<Best, 8> best;
    double low_x, low_y, high_x, high_y, worst = infinity;  // the points' box, the largest of `squared`

    explicit Block(const Eight& asked) : points(asked) {
        for (int k = 0; k < 8; ++k) {
            x[k] = asked[static_cast<std::size_t>(k)].x();
            y[k] = asked[static_cast<std::size_t>(k)].y();
        }
        best.fill({0, 0.0, infinity});
        low_x = x.minCoeff(), low_y = y.minCoeff(), high_x = x.maxCoeff(), high_y = y.maxCoeff();
    }
    void update() {
        for (int k = 0; k < 8; ++k)
            squared[k] = best[static_cast<std::size_t>(k)].squared;
        worst = squared.maxCoeff();
    }
};

/// On a curve of `spans`, which is taken for a closed one.
std::size_t ClosestPointIndex::Trail::next(std::size_t spans) const {
    const auto n = static_cast<double>(spans);
    const double at = static_cast<double>(span) + step;
    return static_cast<std::size_t>(at - n * std::floor(at / n)) % spans;
}

/// Points that run along a curve of short spans, or of known clearances, are searched one by one, each from where it is
/// expected.
std::array<CurveFoot, 8> ClosestPointIndex::follow(const Eight& points, Trail& trail) const {
    const std::size_t spans = leaves_.size();
    std::array<CurveFoot, 8> feet{};
    if (spans == 0) return feet;
    if (clear_squared_.empty() && std::abs(trail.step) < farthest_in_a_block) {
        feet = closest(points, trail.span);
    } else {
        for (std::size_t k = 0; k < feet.size(); ++k) {
            feet[k] = closest(points[k], trail.next(spans));
            trail.span = feet[k].span;
        }
    }
    const auto from = static_cast<double>(feet.front().span), to = static_cast<double>(feet.back().span);
    trail.span = feet.back().span;
    trail.step = std::remainder(to - from, static_cast<double>(spans)) / static_cast<double>(feet.size() - 1);
    return feet;
}

std::array<CurveFoot, 8> ClosestPointIndex::closest(const Eight& points, std::size_t hint) const {
    std::array<CurveFoot, 8> feet;
    if (leaves_.empty()) return feet;
    Block block(points);
    if (!(block.x.abs() < too_far && block.y.abs() < too_far).all()) {
        for (std::size_t k = 0; k < feet.size(); ++k)
            feet[k] = closest(points[k], hint);
        return feet;
    }
    visit(hint, 0xff, block);
    for (std::size_t group = 0; group < levels_.back().size(); ++group)
        search(levels_.size() - 1, group, hint, block);
    for (std::size_t k = 0; k < feet.size(); ++k)
        feet[k] = foot_of(block.best[k]);
    return feet;
}

/// Boxes against the box of all points first, then a span's box against each point.
void ClosestPointIndex::search(std::size_t level, std::size_t group, std::size_t skip, Block& block) const {
    const Group& boxes = levels_[level][group];
    using Stored = Eigen::Map<const Lanes>;
    const Lanes dx =
        (Stored(boxes.low_x.data()) - block.high_x).max(block.low_x - Stored(boxes.high_x.data())).max(0.0);
    const Lanes dy =
        (Stored(boxes.low_y.data()) - block.high_y).max(block.low_y - Stored(boxes.high_y.data())).max(0.0);
    const Lanes squared = dx * dx + dy * dy;
    unsigned open = 0;
    for (int j = 0; j < 8; ++j)
        open |= static_cast<unsigned>(squared[j] < block.worst) << j;
    for (; open != 0; open &= open - 1) {
        const auto j = static_cast<std::size_t>(std::countr_zero(open));
        if (!(squared[static_cast<int>(j)] < block.worst)) continue;
        const std::size_t index = group_size * group + j;
        if (level > 0) {
            search(level - 1, index, skip, block);
        } else if (index != skip) {
            const Lanes px = (boxes.low_x[j] - block.x).max(block.x - boxes.high_x[j]).max(0.0);
            const Lanes py = (boxes.low_y[j] - block.y).max(block.y - boxes.high_y[j]).max(0.0);
            const Lanes away = px * px + py * py;
            unsigned lanes = 0;
            for (int k = 0; k < 8; ++k)
                lanes |= static_cast<unsigned>(away[k] < block.squared[k]) << k;
            if (lanes != 0) visit(index, lanes, block);
        }
    }
}

void ClosestPointIndex::visit(std::size_t leaf, unsigned lanes, Block& block) const {
    if (std::popcount(lanes) < worth_a_block) {
        for (; lanes != 0; lanes &= lanes - 1) {
            const auto k = static_cast<std::size_t>(std::countr_zero(lanes));
            visit(block.points[k], leaf, block.best[k]);
        }
        return block.update();
    }
    const Leaf& span = leaves_[leaf];
    const Lanes qx = block.x - span.start.x(), qy = block.y - span.start.y();
    std::array<std::uint64_t, 8> negative{};
    Lanes first, last;
    for (std::size_t i = 0; i < 6; ++i) {
        const Lanes beta = span.constant[i] - (qx * span.vx[i] + qy * span.vy[i]);
        for (int k = 0; k < 8; ++k)
            negative[static_cast<std::size_t>(k)] |= std::bit_cast<std::uint64_t>(beta[k]) >> 63 << i;
        if (i == 0) first = beta;
        if (i == 5) last = beta;
    }
    // Halley's method from the zero of the chord of g: what has not converged inside the span goes one by one.
    Lanes w = (first / (first - last)).max(0.0).min(1.0), move = w, rx, ry;
    const auto offset = [&] {
        rx = ((w * span.d.x() + span.c.x()) * w + span.b.x()) * w - qx;
        ry = ((w * span.d.y() + span.c.y()) * w + span.b.y()) * w - qy;
    };
    for (int step = 0; step < 2; ++step) {
        offset();
        const Lanes d1x = (w * (3.0 * span.d.x()) + 2.0 * span.c.x()) * w + span.b.x();
        const Lanes d1y = (w * (3.0 * span.d.y()) + 2.0 * span.c.y()) * w + span.b.y();
        const Lanes d2x = w * (6.0 * span.d.x()) + 2.0 * span.c.x(), d2y = w * (6.0 * span.d.y()) + 2.0 * span.c.y();
        const Lanes g = rx * d1x + ry * d1y, slope = d1x * d1x + d1y * d1y + rx * d2x + ry * d2y;
        const Lanes bend = 3.0 * (d1x * d2x + d1y * d2y) + 6.0 * (rx * span.d.x() + ry * span.d.y());
        move = 2.0 * g * slope / (2.0 * slope * slope - g * bend);
        w -= move;
    }
    offset();
    const Lanes squared = rx * rx + ry * ry, start = qx.square() + qy.square();
    const Lanes end = (block.x - span.end.x()).square() + (block.y - span.end.y()).square();
    for (; lanes != 0; lanes &= lanes - 1) {
        const int k = std::countr_zero(lanes);
        const auto at = static_cast<std::size_t>(k);
        Best& best = block.best[at];
        const auto signs = static_cast<unsigned>(negative[at]);
        if (signs == 0 || signs == all_negative || one_maximum(signs)) {
            if (start[k] < best.squared) best = {leaf, 0.0, start[k]};
            if (end[k] < best.squared) best = {leaf, 1.0, end[k]};
        } else if (one_minimum(signs) && std::abs(move[k]) < 3e-5 && w[k] >= 0.0 && w[k] <= 1.0) {
            if (squared[k] < best.squared) best = {leaf, w[k], squared[k]};
        } else {
            visit(block.points[at], leaf, best);
        }
    }
    block.update();
}

}  // namespace cmm::fitting
