// SPDX-License-Identifier: Apache-2.0
#include "sim/bvh.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace cmm::sim {

namespace {

constexpr std::uint32_t leaf_size = 2;
constexpr int bins = 16;
// Below this depth the tree is halved by number, so that it is never deeper than 40 + 32: the walk's stack is enough.
constexpr int cost_depth = 40;
constexpr std::size_t stack_size = 80;

struct Bounds3 {
    Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::max());
    Eigen::Vector3d high = Eigen::Vector3d::Constant(std::numeric_limits<double>::lowest());

    void add(const Eigen::Vector3d& p) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    void add(const Bounds3& other) {
        low = low.cwiseMin(other.low);
        high = high.cwiseMax(other.high);
    }
    double area() const {
        const Eigen::Vector3d d = high - low;
        return d.minCoeff() < 0.0 ? 0.0 : d.x() * d.y() + d.y() * d.z() + d.z() * d.x();
    }
};

double box_distance_sq(const Eigen::Vector3d& p, const std::array<double, 6>& box) {
    double sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double d =
            std::max({box[i] - p[static_cast<Eigen::Index>(i)], 0.0, p[static_cast<Eigen::Index>(i)] - box[i + 3]});
        sum += d * d;
    }
    return sum;
}

}  // namespace

/// Splits by the surface-area heuristic over bins of the triangles' box centres; equal centres are halved.
struct Bvh::Builder {
    std::vector<Node>& nodes;
    std::vector<std::uint32_t>& order;
    std::vector<Bounds3> boxes;

    Bounds3 bounds(std::uint32_t first, std::uint32_t count) const {
        Bounds3 all;
        for (std::uint32_t i = first; i < first + count; ++i)
            all.add(boxes[order[i]]);
        return all;
    }
    Eigen::Vector3d centre(std::uint32_t triangle) const { return 0.5 * (boxes[triangle].low + boxes[triangle].high); }

    /// Returns how many of the range go to the left, having sorted them there.
    std::uint32_t split(std::uint32_t first, std::uint32_t count, int depth) {
        Bounds3 centres;
        for (std::uint32_t i = first; i < first + count; ++i)
            centres.add(centre(order[i]));
        Eigen::Index axis = 0;
        const double extent = (centres.high - centres.low).maxCoeff(&axis);
        const auto begin = order.begin() + first, end = begin + count;
        const double low = centres.low[axis];
        const auto bin_of = [&](std::uint32_t t) {
            return std::min(bins - 1, static_cast<int>(bins * (centre(t)[axis] - low) / extent));
        };
        if (extent > 0.0 && depth < cost_depth) {
            const int best = best_cut(first, count, bin_of);
            const auto middle = std::partition(begin, end, [&](std::uint32_t t) { return bin_of(t) <= best; });
            const auto left = static_cast<std::uint32_t>(middle - begin);
            if (left > 0 && left < count) return left;
        }
        return count / 2;
    }

    template <class BinOf>
    int best_cut(std::uint32_t first, std::uint32_t count, const BinOf& bin_of) const {
        std::array<Bounds3, bins> box;
        std::array<std::uint32_t, bins> number{};
        for (std::uint32_t i = first; i < first + count; ++i) {
            const auto bin = static_cast<std::size_t>(bin_of(order[i]));
            box[bin].add(boxes[order[i]]);
            ++number[bin];
        }
        std::array<double, bins> right_cost{};
        Bounds3 right;
        std::uint32_t right_number = 0;
        for (std::size_t i = bins - 1; i > 0; --i) {
            right.add(box[i]);
            right_number += number[i];
            right_cost[i - 1] = right.area() * right_number;
        }
        int best = 0;
        double best_cost = std::numeric_limits<double>::max();
        Bounds3 left;
        std::uint32_t left_number = 0;
        for (std::size_t i = 0; i + 1 < bins; ++i) {
            left.add(box[i]);
            left_number += number[i];
            const double cost = left.area() * left_number + right_cost[i];
            if (left_number > 0 && left_number < count && cost < best_cost) {
                best_cost = cost;
                best = static_cast<int>(i);
            }
        }
        return best;
    }

    /// Fills one side of a node: a leaf, or the index of a new inner node.
    void child(std::uint32_t node, std::size_t side, std::uint32_t first, std::uint32_t count, int depth) {
        const Bounds3 b = bounds(first, count);
        for (std::size_t i = 0; i < 3; ++i) {
            nodes[node].box[side][i] = b.low[static_cast<Eigen::Index>(i)];
            nodes[node].box[side][i + 3] = b.high[static_cast<Eigen::Index>(i)];
        }
        if (count <= leaf_size) {
            nodes[node].child[side] = first;
            nodes[node].count[side] = count;
            return;
        }
        const auto inner = static_cast<std::uint32_t>(nodes.size());
        nodes[node].child[side] = inner;
        nodes[node].count[side] = 0;
        nodes.push_back(Node{});
        const std::uint32_t left = split(first, count, depth);
        child(inner, 0, first, left, depth + 1);
        child(inner, 1, first + left, count - left, depth + 1);
    }
};

Bvh::Bvh(const TriangleMesh& mesh) {
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), 0U);
    Builder builder{nodes_, order_, {}};
    builder.boxes.resize(count);
    for (std::uint32_t t = 0; t < count; ++t) {
        for (const auto corner : mesh.triangles[t])
            builder.boxes[t].add(mesh.vertices[corner]);
    }
    // The root holds everything in its first child; the second lies at infinity, where nobody goes.
    constexpr double far = std::numeric_limits<double>::max();
    nodes_.push_back(Node{});
    nodes_[0].box[1] = {far, far, far, far, far, far};
    nodes_[0].child[1] = nodes_[0].count[1] = 0;
    builder.child(0, 0, 0, count, 0);
    slots_.reserve(count);
    for (const auto t : order_) {
        const auto& [a, b, c] = mesh.triangles[t];
        const Eigen::Vector3d& corner = mesh.vertices[a];
        slots_.push_back({corner, mesh.vertices[b] - corner, mesh.vertices[c] - corner});
    }
}

void Bvh::scan_leaf(const Eigen::Vector3d& p, std::uint32_t first, std::uint32_t count, Hit& best) const {
    for (std::uint32_t slot = first; slot < first + count; ++slot) {
        const TriangleFoot foot = closest_on_triangle(p, slots_[slot]);
        const double distance_sq = (p - foot.point).squaredNorm();
        if (distance_sq < best.distance_sq) best = {slot, order_[slot], foot.point, foot.feature, distance_sq};
    }
}

Bvh::Hit Bvh::nearest(const Eigen::Vector3d& p, std::size_t start) const {
    Hit best;
    best.distance_sq = std::numeric_limits<double>::max();
    scan_leaf(p, static_cast<std::uint32_t>(start < slots_.size() ? start : 0), 1, best);
    struct Pending {
        std::uint32_t node;
        double distance_sq;
    };
    std::array<Pending, stack_size> stack;
    std::size_t depth = 0;
    stack[depth++] = {0, 0.0};
    while (depth > 0) {
        const Pending item = stack[--depth];
        if (item.distance_sq >= best.distance_sq) continue;
        const Node& node = nodes_[item.node];
        const std::array<double, 2> d{box_distance_sq(p, node.box[0]), box_distance_sq(p, node.box[1])};
        const std::size_t near_side = d[1] < d[0] ? 1 : 0;
        const std::array<std::size_t, 2> sides{near_side, 1 - near_side};
        for (const auto side : sides) {
            if (node.count[side] > 0 && d[side] < best.distance_sq) {
                scan_leaf(p, node.child[side], node.count[side], best);
            }
        }
        for (const auto side : {sides[1], sides[0]}) {
            if (node.count[side] == 0 && d[side] < best.distance_sq) stack[depth++] = {node.child[side], d[side]};
        }
    }
    return best;
}

}  // namespace cmm::sim
