// SPDX-License-Identifier: Apache-2.0
#include "fitting/surface_index.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "fitting/cell_order.hpp"
#include "fitting/foot_step.hpp"
#include "fitting/group_order.hpp"
#include "fitting/lane_bits.hpp"

namespace cmm::fitting {
namespace {

constexpr double no_bound = std::numeric_limits<double>::infinity();
// What could be nearer by less than this does not matter.
constexpr double indifferent_foot_mm = 0.5e-6, indifferent_share = 1e-12;
constexpr double foot_rounding = 1e-14;
// Of a patch of the tree: a tangent that turns more makes loose bounds.
constexpr double patch_turn = 0.25;
constexpr int deepest_patch = 5;
// Splitting ends here whatever the bounds say: far below what the parameters resolve.
constexpr double least_width = 1e-10;
// Cells of the order in which scattered points are visited, per axis; fewer points are not worth a sort.
constexpr double patch_grid_cells = 32.0, cells_of_a_jump = 4.0;
constexpr std::size_t cubes = 32 * 32 * 32, least_in_order = 512;
// More than rounding to single precision does to a coordinate and to the square of a distance; and than reckoning in it
// does to a distance, as a share of the largest coordinate. Beyond `farthest_exact_mm` nothing is excluded by it.
constexpr double rounding_of_float = 0x1p-22, single_precision = 0x1p-19, farthest_exact_mm = 1e6;

float float_below(double value) {
    return static_cast<float>(value - rounding_of_float * std::abs(value));
}

float float_above(double value) {
    return static_cast<float>(value + rounding_of_float * std::abs(value));
}

template <class Item>
bool farther(const Item& a, const Item& b) {
    return a.least > b.least;
}

std::pair<PatchDomain, PatchDomain> halves(const PatchDomain& domain, bool in_u) {
    PatchDomain first = domain, second = domain;
    if (in_u)
        first.u1 = second.u0 = 0.5 * (domain.u0 + domain.u1);
    else
        first.v1 = second.v0 = 0.5 * (domain.v0 + domain.v1);
    return {first, second};
}

}  // namespace

SurfaceIndex::SurfaceIndex(const Surface& surface) : surface_(surface) {
    const CubicAxis &u = surface.u(), &v = surface.v();
    patches_.reserve(u.spans() * v.spans());
    for (std::size_t j = 0; j < v.spans(); ++j)
        for (std::size_t i = 0; i < u.spans(); ++i)
            add_patches({i, j, u.low(i), u.high(i), v.low(j), v.high(j)}, 0);
    bring_neighbours_together();
    build_tree();
}

void SurfaceIndex::add_patches(const PatchDomain& domain, int depth) {
    PatchBounds bounds(surface_, domain);
    if (depth >= deepest_patch || (bounds.turn_u() <= patch_turn && bounds.turn_v() <= patch_turn)) {
        patches_.push_back(bounds);
        return;
    }
    const auto [first, second] = halves(domain, bounds.turn_u() >= bounds.turn_v());
    add_patches(first, depth + 1);
    add_patches(second, depth + 1);
}

/// Patches that are near each other come into one group, and groups that are into one of the level above.
void SurfaceIndex::bring_neighbours_together() {
    std::vector<Vec3> middles;
    middles.reserve(patches_.size());
    for (const PatchBounds& patch : patches_)
        middles.push_back(0.5 * (patch.low() + patch.high()));
    std::vector<std::uint32_t> from_place = order_in_groups(middles, group_size);
    // In place, cycle by cycle: they are large.
    for (std::size_t k = 0; k < patches_.size(); ++k)
        for (std::size_t to = k, from = 0; from_place[to] != to; to = from) {
            from = std::exchange(from_place[to], static_cast<std::uint32_t>(to));
            if (from != k) std::swap(patches_[to], patches_[from]);
        }
}

void SurfaceIndex::build_tree() {
    in_last_group_ = (1U << ((patches_.size() - 1) % group_size + 1)) - 1U;
    groups_.resize((patches_.size() + group_size - 1) / group_size);
    std::vector<Vec3> low(groups_.size(), Vec3::Constant(no_bound)), high(groups_.size(), -low[0]);
    for (std::size_t k = 0; k < patches_.size(); ++k) {
        const std::size_t g = k / group_size;
        groups_[g].set(k % group_size, patches_[k]);
        low[g] = low[g].cwiseMin(patches_[k].low());
        high[g] = high[g].cwiseMax(patches_[k].high());
        extent_ =
            std::max({extent_, patches_[k].low().cwiseAbs().maxCoeff(), patches_[k].high().cwiseAbs().maxCoeff()});
    }
    do {
        std::vector<Group> groups((low.size() + group_size - 1) / group_size);
        std::vector<Vec3> next_low(groups.size(), Vec3::Constant(no_bound)), next_high(groups.size(), -next_low[0]);
        for (Group& group : groups)
            for (int axis = 0; axis < 3; ++axis) {
                group.low[axis].setConstant(std::numeric_limits<float>::infinity());
                group.high[axis].setConstant(-std::numeric_limits<float>::infinity());
            }
        for (std::size_t k = 0; k < low.size(); ++k) {
            const std::size_t g = k / group_size;
            for (int axis = 0; axis < 3; ++axis) {
                groups[g].low[axis][static_cast<int>(k % group_size)] = float_below(low[k][axis]);
                groups[g].high[axis][static_cast<int>(k % group_size)] = float_above(high[k][axis]);
            }
            next_low[g] = next_low[g].cwiseMin(low[k]);
            next_high[g] = next_high[g].cwiseMax(high[k]);
        }
        levels_.push_back(std::move(groups));
        low = std::move(next_low);
        high = std::move(next_high);
    } while (levels_.back().size() > 1);
}

void SurfaceIndex::Best::take(const SurfaceFoot& found, bool minimum) {
    if (!(found.squared < foot.squared)) return;
    foot = found;
    stationary = minimum;
    distance = std::sqrt(found.squared);
    limit = distance - indifferent_foot_mm - indifferent_share * distance;
    limit_above = float_above(std::max(limit, 0.0));
    limit_squared = limit > 0.0 ? static_cast<float>(limit * limit * (1.0 + 8.0 * rounding_of_float)) : 0.0F;
}

SurfaceFoot SurfaceIndex::closest(const Vec3& p, const std::optional<SurfacePlace>& hint, SearchCost* cost) const {
    SurfaceSpans near{surface_.u().spans() / 2, surface_.v().spans() / 2};
    return foot_of(p, hint, near, cost);
}

SurfaceFoot SurfaceIndex::foot_of(const Vec3& p, const std::optional<SurfacePlace>& hint, SurfaceSpans& near,
                                  SearchCost* cost) const {
    Best best{{{surface_.u().front(), surface_.v().front()}, no_bound}};
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 1e100) return best.foot;
    if (hint)
        if (const auto foot = newton_foot(surface_, p, *hint, near, &best.cost)) best.take(*foot, true);
    const double by_newton = best.distance;
    const Rounded rounded(p, extent_);
    if (!std::isfinite(best.distance)) approach(p, rounded, best);
    const std::uint32_t root = 0;
    search(p, rounded, levels_.size() - 1, {&root, 1}, best);
    settle(p, best);
    if (cost != nullptr) {
        cost->steps += best.cost.steps;
        cost->failures += best.cost.failures;
        cost->split += best.cost.split;
        cost->wrong += std::isfinite(by_newton) && best.distance < by_newton - indifferent_foot_mm;
    }
    return best.foot;
}

SurfaceIndex::Rounded::Rounded(const Vec3& p, double extent) {
    const double size = std::max(p.cwiseAbs().maxCoeff(), extent);
    const bool far = size > farthest_exact_mm;
    slack = far ? std::numeric_limits<float>::infinity() : static_cast<float>(single_precision * size);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double at = p[static_cast<Eigen::Index>(axis)];
        low[axis] = far ? std::numeric_limits<float>::lowest() : float_below(at);
        high[axis] = far ? std::numeric_limits<float>::max() : float_above(at);
        middle[axis] = far ? 0.0F : static_cast<float>(at);
    }
}

SurfaceIndex::Lanes SurfaceIndex::Group::squares(const Rounded& p) const {
    Lanes sum = Lanes::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const Lanes away = (low[axis] - p.high[axis]).max(p.low[axis] - high[axis]).max(0.0F);
        sum += away * away;
    }
    return sum;
}

/// Without proof: down the tree to a patch of what seems nearest.
void SurfaceIndex::approach(const Vec3& p, const Rounded& rounded, Best& best) const {
    std::size_t box = 0;
    for (std::size_t level = levels_.size(); level-- > 0;) {
        int nearest = 0;
        levels_[level][box].squares(rounded).minCoeff(&nearest);
        box = group_size * box + static_cast<std::size_t>(nearest);
    }
    minimise(p, patches_[group_size * box].domain(), best);
}

/// All of these groups that could be nearer.
void SurfaceIndex::search(const Vec3& p, const Rounded& rounded, std::size_t level,
                          std::span<const std::uint32_t> groups, Best& best) const {
    std::array<std::uint32_t, group_size * most_groups_at_once> left;
    while (!groups.empty()) {
        const auto now = groups.first(std::min<std::size_t>(groups.size(), most_groups_at_once));
        groups = groups.subspan(now.size());
        std::size_t count = 0;
        for (const std::uint32_t group : now) {
            const Lanes squares = levels_[level][group].squares(rounded);
            const std::uint32_t near = lanes_where(squares, std::less<>(), best.limit_squared);
            count += list_lanes(near, group_size * group, &left[count]);
        }
        const std::span<const std::uint32_t> below(left.data(), count);
        if (level > 0)
            search(p, rounded, level - 1, below, best);
        else
            look_at(p, rounded, below, best);
    }
}

/// Their patches that could be nearer, the nearest first.
void SurfaceIndex::look_at(const Vec3& p, const Rounded& rounded, std::span<const std::uint32_t> groups,
                           Best& best) const {
    constexpr std::size_t most = group_size * group_size * most_groups_at_once;
    std::array<std::uint32_t, most> left;  // as many patches behind the first of the first group
    std::array<float, most> away;          // of all of them
    std::size_t count = 0;
    const float limit = best.limit_above + rounded.slack;
    for (std::uint32_t g = 0; g < groups.size(); ++g) {
        const Lanes least = groups_[groups[g]].least_distances(rounded.middle);
        std::copy_n(least.data(), group_size, &away[group_size * g]);
        const std::uint32_t far = lanes_where(least, std::greater<>(), limit);
        count += list_lanes(~far & filled(groups[g]), group_size * g, &left[count]);
    }
    while (count > 0) {
        const auto nearest = std::min_element(left.begin(), left.begin() + count,
                                              [&](std::uint32_t a, std::uint32_t b) { return away[a] < away[b]; });
        const std::uint32_t patch = *nearest;
        if (away[patch] > best.limit_above + rounded.slack) return;
        visit(p, patches_[group_size * groups[patch / group_size] + patch % group_size], best);
        *nearest = left[--count];
    }
}

/// A bit for each patch that a group has.
std::uint32_t SurfaceIndex::filled(std::uint32_t group) const {
    return group + 1 < groups_.size() ? 0xffU : in_last_group_;
}

void SurfaceIndex::visit(const Vec3& p, const PatchBounds& patch, Best& best) const {
    if (!patch.nearer_than(best.limit, p)) return;
    if (patch.convex_for(p)) return minimise(p, patch.domain(), best);
    best.undecided.push_back({patch.least_distance(p), patch});
    std::push_heap(best.undecided.begin(), best.undecided.end(), farther<Undecided>);
}

/// Patches on which |S - p|^2 may have several minima are halved, those that could be nearest first, until each is
/// too far away or convex.
void SurfaceIndex::settle(const Vec3& p, Best& best) const {
    while (!best.undecided.empty()) {
        std::pop_heap(best.undecided.begin(), best.undecided.end(), farther<Undecided>);
        const Undecided next = std::move(best.undecided.back());
        best.undecided.pop_back();
        if (!(next.least < best.limit)) return;
        sound(p, next.patch.domain(), best);
        const bool in_u = next.patch.turn_u() >= next.patch.turn_v();
        const PatchDomain& domain = next.patch.domain();
        const CubicAxis& axis = in_u ? surface_.u() : surface_.v();
        const double width = in_u ? domain.u1 - domain.u0 : domain.v1 - domain.v0;
        if (width < least_width * (axis.back() - axis.front())) continue;
        ++best.cost.split;
        const auto [first, second] = halves(domain, in_u);
        visit(p, PatchBounds(surface_, first), best);
        visit(p, PatchBounds(surface_, second), best);
    }
}

/// Without proof. Corners are nearer than a saddle or a farthest place between them, where Newton's method may end.
void SurfaceIndex::sound(const Vec3& p, const PatchDomain& domain, Best& best) const {
    for (const double u : {domain.u0, domain.u1})
        for (const double v : {domain.v0, domain.v1}) {
            const double squared = (surface_.position_in(domain.span_u, domain.span_v, {u, v}) - p).squaredNorm();
            best.take({{u, v}, squared}, false);
        }
    minimise(p, domain, best);
}

/// Newton's method on the rectangle, with bounds that hold while the gradient pushes outwards (Bertsekas 1982), a step
/// that does not lead downhill halved.
void SurfaceIndex::minimise(const Vec3& p, const PatchDomain& domain, Best& best) const {
    SurfacePlace at{0.5 * (domain.u0 + domain.u1), 0.5 * (domain.v0 + domain.v1)};
    if (std::isfinite(best.distance)) {
        if (best.stationary && domain.holds(best.foot.place)) return;
        at = domain.clamped(best.foot.place);
        // Across the seam the nearer end is the other one.
        const double period = surface_.u().back() - surface_.u().front();
        if (surface_.u().closed() && std::abs(at.u - best.foot.place.u) > 0.5 * period)
            at.u = at.u > domain.u0 ? domain.u0 : domain.u1;
    }
    double last = no_bound;
    SurfacePlace before = at;
    for (int step = 0; step < most_foot_steps; ++step) {
        const SurfaceJet jet = surface_.jet_in(domain.span_u, domain.span_v, at);
        const Vec3 r = jet.position - p;
        const double squared = r.squaredNorm();
        ++best.cost.steps;
        if (squared > last * (1.0 + foot_rounding)) {
            at = {0.5 * (at.u + before.u), 0.5 * (at.v + before.v)};
            continue;
        }
        last = squared;
        best.take({at, squared}, false);
        const FootSlope slope(jet, r);
        const bool free_u = !held_at_bound(at.u, domain.u0, domain.u1, slope.gu);
        const bool free_v = !held_at_bound(at.v, domain.v0, domain.v1, slope.gv);
        const FootStep move = foot_step(slope, free_u, free_v);
        const SurfacePlace next = domain.clamped({at.u + move.u, at.v + move.v});
        const double length = slope.length(next.u - at.u, next.v - at.v);
        before = at;
        at = next;
        if (!(length > longest_last_foot_step_mm * longest_last_foot_step_mm)) {
            const bool inside = next.u == before.u + move.u && next.v == before.v + move.v;
            const double there = (surface_.position_in(domain.span_u, domain.span_v, at) - p).squaredNorm();
            best.take({at, there}, free_u && free_v && inside);
            if (!is_last_foot_step(length, there) && length > 0.0) continue;
            // The step may gain nothing but rounding: then the place before it is the minimum.
            if (best.foot.place.u == before.u && best.foot.place.v == before.v) best.stationary = free_u && free_v;
            return;
        }
    }
}

std::vector<std::uint32_t> SurfaceIndex::neighbours_first(std::span<const Vec3> points) const {
    if (points.size() < least_in_order || points.size() > std::numeric_limits<std::uint32_t>::max()) return {};
    Vec3 low = patches_[0].low(), high = patches_[0].high();
    for (const PatchBounds& patch : patches_) {
        low = low.cwiseMin(patch.low());
        high = high.cwiseMax(patch.high());
    }
    const double margin = 0.05 * (high - low).norm();
    low.array() -= margin;
    const Vec3 scale = (patch_grid_cells / (high.array() + margin - low.array()));
    std::vector<std::uint16_t> cell(points.size());
    std::size_t jumps = 0;
    for (std::size_t i = 1; i < points.size(); ++i)
        jumps += !((points[i] - points[i - 1]).cwiseProduct(scale).cwiseAbs().maxCoeff() < cells_of_a_jump);
    if (jumps < points.size() / 4) return {};
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint32_t index = 0;
        for (const int axis : {2, 1, 0}) {
            const double at = (points[i][axis] - low[axis]) * scale[axis];
            index = index * static_cast<std::uint32_t>(patch_grid_cells) +
                    static_cast<std::uint32_t>(std::max(0.0, std::min(at, patch_grid_cells - 1.0)));  // also of NaN
        }
        cell[i] = static_cast<std::uint16_t>(index);
    }
    return order_by_cell(cell, cubes);
}

void SurfaceIndex::closest(std::span<const Vec3> points, std::span<SurfaceFoot> feet, SearchCost* cost) const {
    const std::vector<std::uint32_t> order = neighbours_first(points);
    std::optional<SurfacePlace> last, hint;
    SurfaceSpans near;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::size_t i = order.empty() ? k : order[k];
        feet[i] = foot_of(points[i], hint, near, cost);
        const SurfacePlace& now = feet[i].place;
        hint = now;
        // A scan goes on as it went.
        if (last && order.empty()) hint = SurfacePlace{2.0 * now.u - last->u, 2.0 * now.v - last->v};
        last = now;
    }
}

}  // namespace cmm::fitting
