// SPDX-License-Identifier: Apache-2.0
#include "fitting/closest_point.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "fitting/bernstein_signs.hpp"
#include "fitting/cell_order.hpp"

namespace cmm::fitting {
namespace {

// A counting sort by cells pays from this many points on.
constexpr std::size_t least_to_sort = 2048, cell_count = 128 * 128;
constexpr double grid_cells = 128.0;
constexpr double infinite = std::numeric_limits<double>::infinity();
// A part of a span that could be nearer by less than this does not matter (0.1 pm at 1 mm).
constexpr double indifferent_mm = 1e-10;
constexpr std::size_t longest_walk = 16;  // spans from a hint

Vec2 offset_at(const Vec2& b, const Vec2& c, const Vec2& d, const Vec2& q, double w) {
    return ((w * d + c) * w + b) * w - q;
}

/// Zero of the control polygon: near the root, as the polygon is near the curve.
double polygon_zero(const std::array<double, 6>& beta, unsigned negative) {
    const auto i = static_cast<std::size_t>(std::countr_one(negative)) - 1;
    return 0.2 * (static_cast<double>(i) + beta[i] / (beta[i] - beta[i + 1]));
}

}  // namespace

ClosestPointIndex::ClosestPointIndex(const PiecewiseCubic& curve) {
    const std::size_t spans = curve.spans();
    if (spans == 0) return;
    leaves_.reserve(spans);
    std::vector<Group> groups((spans + group_size - 1) / group_size);
    for (std::size_t k = 0; k < spans; ++k) {
        const double h = curve.breaks()[k + 1] - curve.breaks()[k];
        const auto& [a, b1, c1, d1] = curve.pieces()[k];
        Leaf leaf{{}, {}, {}, a, h * b1, h * h * c1, h * h * h * d1, {}, curve.breaks()[k], h};
        const Vec2 &b = leaf.b, &c = leaf.c, &d = leaf.d;
        leaf.end = a + (b + c + d);
        // g(w) = -q.b + (b.b - 2 q.c) w + 3 (b.c - q.d) w^2 + (4 b.d + 2 c.c) w^3 + 5 c.d w^4 + 3 d.d w^5
        const std::array<double, 6> power{0.0,
                                          b.squaredNorm(),
                                          3.0 * b.dot(c),
                                          4.0 * b.dot(d) + 2.0 * c.squaredNorm(),
                                          5.0 * c.dot(d),
                                          3.0 * d.squaredNorm()};
        constexpr std::array<std::array<double, 6>, 6> to_bernstein{{{1, 0, 0, 0, 0, 0},
                                                                     {1, 0.2, 0, 0, 0, 0},
                                                                     {1, 0.4, 0.1, 0, 0, 0},
                                                                     {1, 0.6, 0.3, 0.1, 0, 0},
                                                                     {1, 0.8, 0.6, 0.4, 0.2, 0},
                                                                     {1, 1, 1, 1, 1, 1}}};
        for (std::size_t i = 0; i < 6; ++i) {
            const auto& row = to_bernstein[i];
            const Vec2 v = b + (2.0 * row[1]) * c + (3.0 * row[2]) * d;
            leaf.vx[i] = v.x();
            leaf.vy[i] = v.y();
            leaf.constant[i] = 0.0;
            for (std::size_t j = 1; j < 6; ++j)
                leaf.constant[i] += row[j] * power[j];
        }
        const Vec2 p1 = a + b / 3.0, p2 = a + (2.0 / 3.0) * b + c / 3.0;  // Bezier points: their box holds the span
        set_box(groups, k, a.cwiseMin(p1).cwiseMin(p2).cwiseMin(leaf.end),
                a.cwiseMax(p1).cwiseMax(p2).cwiseMax(leaf.end));
        leaves_.push_back(leaf);
    }
    for (std::size_t boxes = spans;; boxes = groups.size()) {
        if (!levels_.empty()) {
            const std::vector<Group>& below = levels_.back();
            groups.assign((boxes + group_size - 1) / group_size, Group{});
            const auto low = [](const auto& side) { return *std::min_element(side.begin(), side.end()); };
            const auto high = [](const auto& side) { return *std::max_element(side.begin(), side.end()); };
            for (std::size_t j = 0; j < boxes; ++j)
                set_box(groups, j, {low(below[j].low_x), low(below[j].low_y)},
                        {high(below[j].high_x), high(below[j].high_y)});
        }
        for (std::size_t j = boxes; j < group_size * groups.size(); ++j)
            set_box(groups, j, Vec2::Constant(infinite), Vec2::Constant(-infinite));
        levels_.push_back(groups);
        if (groups.size() <= 2) break;
    }
}

void ClosestPointIndex::set_box(std::vector<Group>& groups, std::size_t at, const Vec2& low, const Vec2& high) const {
    Group& group = groups[at / group_size];
    const std::size_t j = at % group_size;
    group.low_x[j] = low.x(), group.low_y[j] = low.y(), group.high_x[j] = high.x(), group.high_y[j] = high.y();
}

CurveFoot ClosestPointIndex::closest(const Vec2& point, std::size_t hint) const {
    if (leaves_.empty()) return {};
    Best best{0, 0.0, infinite};
    if (hint < leaves_.size()) {
        visit(point, hint, best);
        // Downhill into the spans beside it, so that the boxes are asked with a foot that nothing much is nearer than.
        const std::size_t spans = leaves_.size();
        for (std::size_t leaf = hint, step = 0; step < longest_walk && (best.w == 0.0 || best.w == 1.0); ++step) {
            leaf = best.w == 1.0 ? (leaf + 1) % spans : (leaf + spans - 1) % spans;
            visit(point, leaf, best);
            if (best.leaf != leaf) break;
        }
        if (is_clear(best)) return foot_of(best);
    }
    for (std::size_t group = 0; group < levels_.back().size(); ++group)
        search(point, levels_.size() - 1, group, hint, best);
    return foot_of(best);
}

CurveFoot ClosestPointIndex::foot_of(const Best& best) const {
    const Leaf& leaf = leaves_[best.leaf];
    return {best.leaf, leaf.from + best.w * leaf.width, best.squared};
}

/// Nearest box first, then whatever is still nearer than the best.
void ClosestPointIndex::search(const Vec2& point, std::size_t level, std::size_t group, std::size_t skip,
                               Best& best) const {
    const Group& boxes = levels_[level][group];
    using Sides = Eigen::Array<double, group_size, 1>;
    using Stored = Eigen::Map<const Sides>;
    const Sides dx = (Stored(boxes.low_x.data()) - point.x()).max(point.x() - Stored(boxes.high_x.data())).max(0.0);
    const Sides dy = (Stored(boxes.low_y.data()) - point.y()).max(point.y() - Stored(boxes.high_y.data())).max(0.0);
    const Sides distances = dx * dx + dy * dy;
    std::array<double, group_size> squared;
    Eigen::Map<Sides>(squared.data()) = distances;
    unsigned open = 0;
    for (std::size_t j = 0; j < group_size; ++j)
        open |= static_cast<unsigned>(squared[j] < best.squared) << j;
    if (open == 0) return;
    std::size_t next = static_cast<std::size_t>(std::countr_zero(open));
    if ((open & (open - 1)) != 0)
        for (std::size_t j = next + 1; j < group_size; ++j)
            next = squared[j] < squared[next] ? j : next;
    for (;;) {
        const std::size_t index = group_size * group + next;
        if (level > 0)
            search(point, level - 1, index, skip, best);
        else if (index != skip)
            visit(point, index, best);
        open &= ~(1U << next);
        do {
            if (open == 0) return;
            next = static_cast<std::size_t>(std::countr_zero(open));
            open &= open - 1;
        } while (!(squared[next] < best.squared));
    }
}

std::vector<std::uint32_t> ClosestPointIndex::neighbours_first(std::span<const Vec2> points) const {
    if (leaves_.empty() || points.size() < least_to_sort || points.size() > std::numeric_limits<std::uint32_t>::max())
        return {};
    Vec2 low = leaves_[0].start, high = low;
    for (const Leaf& leaf : leaves_) {
        low = low.cwiseMin(leaf.start);
        high = high.cwiseMax(leaf.start);
    }
    const double margin = 0.25 * (high - low).norm();
    low.array() -= margin;
    const Vec2 scale = (grid_cells / (high.array() + margin - low.array()));
    const auto axis = [](double at) {  // also of NaN
        return static_cast<std::uint32_t>(std::max(0.0, std::min(at, grid_cells - 1.0)));
    };
    std::vector<std::uint16_t> cell(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec2 at = (points[i] - low).cwiseProduct(scale);
        const std::uint32_t row = axis(at.y()), column = axis(at.x());
        cell[i] = static_cast<std::uint16_t>(row * static_cast<std::uint32_t>(grid_cells) + column);
    }
    return order_by_cell(cell, cell_count);
}

void ClosestPointIndex::visit(const Vec2& point, std::size_t leaf, Best& best) const {
    const Leaf& span = leaves_[leaf];
    const Vec2 q = point - span.start;
    using Six = Eigen::Array<double, 6, 1>;
    using Stored = Eigen::Map<const Six>;
    const Six coefficients =
        Stored(span.constant.data()) - (q.x() * Stored(span.vx.data()) + q.y() * Stored(span.vy.data()));
    Bernstein beta;
    Eigen::Map<Six>(beta.data()) = coefficients;
    const unsigned negative = negative_signs(beta);
    const double start = q.squaredNorm();
    if (one_minimum(negative) && negative != 0 && negative != all_negative) {
        // |C - p|^2 has the Bernstein coefficients start + (1/3) (beta_0 + ... + beta_i): the least is a bound.
        const double bound = start + coefficients.min(0.0).sum() * (1.0 / 3.0);
        if (bound < best.squared) solve(span, q, 0.0, 1.0, polygon_zero(beta, negative), leaf, best);
        return;
    }
    const double end = (point - span.end).squaredNorm();
    if (start < best.squared) best = {leaf, 0.0, start};
    if (end < best.squared) best = {leaf, 1.0, end};
    if (negative != 0 && !one_maximum(negative)) split(span, q, beta, 0.0, 1.0, leaf, best);
}

/// Halley's method on g, held in the bracket (g is negative at `low`, positive at `high`).
void ClosestPointIndex::solve(const Leaf& span, const Vec2& q, double low, double high, double w, std::size_t leaf,
                              Best& best) const {
    for (int step = 0; step < 64; ++step) {
        const Vec2 r = offset_at(span.b, span.c, span.d, q, w);
        const Vec2 d1 = (3.0 * w * span.d + 2.0 * span.c) * w + span.b, d2 = 6.0 * w * span.d + 2.0 * span.c;
        const double g = r.dot(d1), slope = d1.squaredNorm() + r.dot(d2), bend = 3.0 * d1.dot(d2) + 6.0 * r.dot(span.d);
        (g < 0.0 ? low : high) = w;
        double next = w - 2.0 * g * slope / (2.0 * slope * slope - g * bend);
        if (!(next >= low && next <= high)) next = 0.5 * (low + high);
        const double move = std::abs(next - w);
        w = next;
        if (move < 3e-5) break;  // the step just made cubes this
    }
    const double squared = offset_at(span.b, span.c, span.d, q, w).squaredNorm();
    if (squared < best.squared) best = {leaf, w, squared};
}

/// Halves the span until every part is monotonous, convex or out of the question.
void ClosestPointIndex::split(const Leaf& span, const Vec2& q, const Bernstein& beta, double low, double high,
                              std::size_t leaf, Best& best) const {
    const unsigned negative = negative_signs(beta);
    const double start = offset_at(span.b, span.c, span.d, q, low).squaredNorm();
    if (start < best.squared) best = {leaf, low, start};
    if (negative == 0 || negative == all_negative || one_maximum(negative)) return;
    double bound = start, coefficient = start;
    for (const double value : beta) {
        coefficient += (high - low) / 3.0 * value;
        bound = std::min(bound, coefficient);
    }
    if (!(bound < best.squared - 2.0 * indifferent_mm * std::sqrt(best.squared)) || high - low < 1e-9) return;
    if (one_minimum(negative))
        return solve(span, q, low, high, low + (high - low) * polygon_zero(beta, negative), leaf, best);
    Bernstein left, right = beta;  // de Casteljau
    for (std::size_t i = 0; i < 6; ++i) {
        left[i] = right[0];
        for (std::size_t j = 0; j + 1 < 6 - i; ++j)
            right[j] = 0.5 * (right[j] + right[j + 1]);
    }
    const double middle = 0.5 * (low + high);
    split(span, q, left, low, middle, leaf, best);
    split(span, q, right, middle, high, leaf, best);
}

}  // namespace cmm::fitting
