// SPDX-License-Identifier: Apache-2.0
#include "fitting/crossings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

namespace cmm::fitting {
namespace {

constexpr double rounding_mm = 1e-12;
constexpr double least_mm = 3e-10;  // of what is halved: smaller loops do not count
constexpr double same_crossing_mm = 1e-9;
constexpr double half_turn_rad = std::numbers::pi - 1e-6;
constexpr int most_halvings = 100;    // of both: below the spacing of numbers
constexpr int most_visits = 100'000;  // only curves that run along themselves need more: those do not cross

struct Box {
    double low_x, high_x, low_y, high_y;

    explicit Box(const Stretch& s)
        : low_x(std::min(s.begin.x(), s.end.x()) - s.reach - rounding_mm),
          high_x(std::max(s.begin.x(), s.end.x()) + s.reach + rounding_mm),
          low_y(std::min(s.begin.y(), s.end.y()) - s.reach - rounding_mm),
          high_y(std::max(s.begin.y(), s.end.y()) + s.reach + rounding_mm) {}

    bool meets(const Box& other) const {
        return low_x <= other.high_x && other.low_x <= high_x && low_y <= other.high_y && other.low_y <= high_y;
    }
};

double squared_distance(const Vec2& p, const Vec2& from, const Vec2& to) {
    const Vec2 along = to - from;
    const double squared = along.squaredNorm();
    const double share = squared > 0.0 ? std::clamp((p - from).dot(along) / squared, 0.0, 1.0) : 0.0;
    return (p - from - share * along).squaredNorm();
}

/// Whether the chords are farther apart than both arcs may leave them.
bool apart(const Stretch& a, const Stretch& b) {
    const double turn_a = cross(a.end - a.begin, b.begin - a.begin) * cross(a.end - a.begin, b.end - a.begin);
    const double turn_b = cross(b.end - b.begin, a.begin - b.begin) * cross(b.end - b.begin, a.end - b.begin);
    if (turn_a <= 0.0 && turn_b <= 0.0) return false;
    const double reach = a.reach + b.reach + rounding_mm, limit = reach * reach;
    return squared_distance(a.begin, b.begin, b.end) > limit && squared_distance(a.end, b.begin, b.end) > limit &&
           squared_distance(b.begin, a.begin, a.end) > limit && squared_distance(b.end, a.begin, a.end) > limit;
}

double size_of(const Stretch& s) {
    return (s.end - s.begin).norm() + s.reach;
}

/// The two branches of a cusp of a curve that bends one way lie on either side of its tangent.
bool is_simple_cusp(const Stretch& a, const Stretch& b) {
    return a.backwards != b.backwards && ((a.left && b.left) || (a.right && b.right)) &&
           a.turn + b.turn < half_turn_rad;
}

class CrossingSearch {
  public:
    explicit CrossingSearch(const ParallelCurve& curve) : curve_(curve), all_(curve.stretches()) {
        turned_.resize(all_.size() + 1, 0.0);
        run_.resize(all_.size(), 0);
        left_from_.resize(all_.size(), 0);
        right_from_.resize(all_.size(), 0);
        for (std::size_t i = 0; i < all_.size(); ++i) {
            left_from_[i] = !all_[i].left ? i + 1 : i > 0 ? left_from_[i - 1] : 0;
            right_from_[i] = !all_[i].right ? i + 1 : i > 0 ? right_from_[i - 1] : 0;
            turned_[i + 1] = turned_[i] + all_[i].turn;
            if (i > 0) run_[i] = run_[i - 1] + (all_[i].backwards != all_[i - 1].backwards ? 1 : 0);
        }
    }

    /// Boxes in the order of their left sides: only those that overlap in x are compared.
    std::vector<Crossing> run() && {
        std::vector<Box> boxes(all_.begin(), all_.end());
        std::vector<std::size_t> order(all_.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return boxes[a].low_x < boxes[b].low_x; });
        for (std::size_t k = 0; k < order.size(); ++k) {
            const Box& box = boxes[order[k]];
            for (std::size_t m = k + 1; m < order.size() && boxes[order[m]].low_x <= box.high_x; ++m)
                if (box.meets(boxes[order[m]])) compare(std::min(order[k], order[m]), std::max(order[k], order[m]));
        }
        return std::move(found_);
    }

  private:
    void compare(std::size_t i, std::size_t j) {
        const std::size_t n = all_.size();
        // Regular, or with one cusp and bent one way.
        const bool simple =
            run_[i] == run_[j] || (run_[i] + 1 == run_[j] && std::min(left_from_[j], right_from_[j]) <= i);
        if (simple && turned_[j + 1] - turned_[i] < half_turn_rad) return;
        const bool round_the_start =
            run_[j] == run_.back() && run_[i] == 0 && all_.front().backwards == all_.back().backwards;
        if (round_the_start && turned_[n] - turned_[j] + turned_[i + 1] < half_turn_rad) return;
        first_ = i;
        second_ = j;
        if (i == 0 && j + 1 == n && n > 2) return meet(all_[j], all_[i], true, true, 0);
        meet(all_[i], all_[j], j == i + 1, false, 0);
    }

    /// `touching`: b begins where a ends. `swapped`: a lies on the later stretch.
    void meet(const Stretch& a, const Stretch& b, bool touching, bool swapped, int depth) {
        if (++visits_ > most_visits || depth > most_halvings || !Box(a).meets(Box(b)) || apart(a, b)) return;
        if (touching && is_simple_cusp(a, b)) return;
        if (!touching && angle_between(a, b) > a.turn + b.turn && meet_once(a, b, swapped)) return;
        const double size_a = size_of(a), size_b = size_of(b);
        if (std::max(size_a, size_b) < least_mm) return;  // they touch, but do not cross
        if (size_a >= size_b) {
            const double middle = 0.5 * (a.from + a.to);
            meet(curve_.part(a, a.from, middle), b, false, swapped, depth + 1);
            meet(curve_.part(a, middle, a.to), b, touching, swapped, depth + 1);
        } else {
            const double middle = 0.5 * (b.from + b.to);
            meet(a, curve_.part(b, b.from, middle), touching, swapped, depth + 1);
            meet(a, curve_.part(b, middle, b.to), false, swapped, depth + 1);
        }
    }

    /// Between the tangents' lines, in [0, pi/2].
    double angle_between(const Stretch& a, const Stretch& b) const {
        const Vec2 u = curve_.at(a, a.from).normal, v = curve_.at(b, b.from).normal;
        return std::atan2(std::abs(cross(u, v)), std::abs(u.dot(v)));
    }

    /// Whether Newton's method leads to a crossing of two arcs that cannot meet twice.
    bool meet_once(const Stretch& a, const Stretch& b, bool swapped) {
        const double width_a = a.to - a.from, width_b = b.to - b.from;
        double x = a.from + 0.5 * width_a, y = b.from + 0.5 * width_b;
        for (int step = 0; step < 12; ++step) {
            const Vec2 gap = curve_.at(b, y).position - curve_.at(a, x).position;
            const Vec2 u = curve_.derivative(a, x), v = curve_.derivative(b, y);
            const double across = cross(u, v);
            if (across == 0.0) return false;
            const double dx = cross(gap, v) / across, dy = cross(gap, u) / across;
            x += std::clamp(dx, -std::abs(width_a), std::abs(width_a));
            y += std::clamp(dy, -std::abs(width_b), std::abs(width_b));
            if (gap.norm() <= rounding_mm) {
                constexpr double slack = 1e-6;  // on the border of two halves it is found from either side
                const double share_a = (x - a.from) / width_a, share_b = (y - b.from) / width_b;
                if (std::min(share_a, share_b) < -slack || std::max(share_a, share_b) > 1.0 + slack) return false;
                x = a.from + std::clamp(share_a, 0.0, 1.0) * width_a;
                y = b.from + std::clamp(share_b, 0.0, 1.0) * width_b;
                add(x, y, curve_.at(a, x).position, swapped);
                return true;
            }
        }
        return false;
    }

    void add(double x, double y, const Vec2& position, bool swapped) {
        for (const Crossing& known : found_) {
            const bool neighbours = near(known.first, first_) && near(known.second, second_);
            if (neighbours && (known.position - position).norm() < same_crossing_mm) return;
        }
        if (swapped) std::swap(x, y);
        found_.push_back({first_, second_, x, y, position});
    }

    bool near(std::size_t a, std::size_t b) const {
        const std::size_t apart = (a + all_.size() - b) % all_.size();
        return apart <= 1 || apart + 1 == all_.size();
    }

    const ParallelCurve& curve_;
    const std::vector<Stretch>& all_;
    std::vector<double> turned_;                       // before a stretch
    std::vector<std::size_t> run_;                     // how often the direction changed before
    std::vector<std::size_t> left_from_, right_from_;  // from there on all turn left, right
    std::vector<Crossing> found_;
    std::size_t first_ = 0, second_ = 0;
    int visits_ = 0;
};

}  // namespace

std::vector<Crossing> find_crossings(const ParallelCurve& curve) {
    return CrossingSearch(curve).run();
}

}  // namespace cmm::fitting
