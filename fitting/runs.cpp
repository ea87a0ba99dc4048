// SPDX-License-Identifier: Apache-2.0
#include "fitting/runs.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace cmm::fitting {
namespace {

constexpr std::size_t side_points = 7;  // on each side: 14 points for 5 coefficients
constexpr std::size_t shortest = 2, longest = 4;
constexpr double floor_share = 1.5;     // of the floor: the quartic bridges a wider gap than the cubic of A8
constexpr double scatter_factor = 8.0;  // times the scatter of the neighbours about the quartic
using Powers = Eigen::Matrix<double, 5, 1>;

Powers powers_of(double x) {
    Powers p;
    p << 1.0, x, x * x, x * x * x, x * x * x * x;
    return p;
}

/// The neighbours of a run in a frame along their chord, x scaled to about [-1, 1], with the quartic through them.
struct Bridge {
    Vec2 origin, along;
    double scale = 1.0, scatter_mm = 0.0;
    Powers coefficients;

    Vec2 local(const Vec2& p) const {
        const Vec2 d = p - origin;
        return {d.dot(along) / scale, cross(along, d)};
    }
    double residual(const Vec2& p) const {
        const Vec2 q = local(p);
        return q.y() - coefficients.dot(powers_of(q.x()));
    }
};

using Sides = std::array<Vec2, 2 * side_points>;

/// Nothing when the neighbours do not advance along their chord (a hairpin).
std::optional<Bridge> bridge_over(const Sides& sides) {
    Bridge bridge;
    const Vec2 chord = sides.back() - sides.front();
    if (chord.norm() <= 0.0) return std::nullopt;
    bridge.origin = 0.5 * (sides.front() + sides.back());
    bridge.along = chord.normalized();
    bridge.scale = 0.5 * chord.norm();
    Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
    Powers right = Powers::Zero();
    double last = -2.0;
    for (const Vec2& p : sides) {
        const Vec2 q = bridge.local(p);
        if (q.x() <= last) return std::nullopt;
        last = q.x();
        const Powers row = powers_of(q.x());
        normal += row * row.transpose();
        right += row * q.y();
    }
    bridge.coefficients = normal.ldlt().solve(right);
    double squares = 0.0;
    for (const Vec2& p : sides) {
        const double r = bridge.residual(p);
        squares += r * r;
    }
    bridge.scatter_mm = std::sqrt(squares / static_cast<double>(2 * side_points - 5));
    return bridge;
}

class RunFinder {
  public:
    RunFinder(std::span<const Vec2> points, bool closed, double floor_mm, BadPoints& found)
        : points_(points), closed_(closed), n_(points.size()), floor_mm_(floor_mm), found_(found) {}

    std::size_t run() {
        std::size_t marked = 0;
        for (std::size_t first = 0; first < n_; ++first) {
            for (std::size_t length = shortest; length <= longest; ++length) {
                if (!marks(first, length)) continue;
                marked += length;
                break;
            }
        }
        return marked;
    }

  private:
    /// The good points next to `from` in a direction; false when there are not enough.
    bool neighbours(std::size_t from, bool forward, std::array<Vec2, side_points>& out) const {
        std::size_t count = 0;
        std::size_t at = from;
        for (std::size_t walked = 0; walked < 4 * side_points && count < side_points; ++walked) {
            if (!closed_ && (forward ? at + 1 >= n_ : at == 0)) return false;
            at = forward ? (at + 1) % n_ : (at + n_ - 1) % n_;
            if (!found_.bad[at]) out[count++] = points_[at];
        }
        return count == side_points;
    }

    bool marks(std::size_t first, std::size_t length) {
        if (n_ < 4 * side_points || (!closed_ && first + length > n_)) return false;
        for (std::size_t k = 0; k < length; ++k) {
            if (found_.bad[(first + k) % n_]) return false;
        }
        std::array<Vec2, side_points> before, after;
        if (!neighbours(first, false, before) || !neighbours((first + length - 1) % n_, true, after)) return false;
        Sides sides;
        std::reverse_copy(before.begin(), before.end(), sides.begin());
        std::copy(after.begin(), after.end(), sides.begin() + side_points);
        const auto bridge = bridge_over(sides);
        if (!bridge) return false;
        const double least = std::max(floor_share * floor_mm_, scatter_factor * bridge->scatter_mm);
        std::array<double, longest> residual{};
        for (std::size_t k = 0; k < length; ++k) {
            residual[k] = bridge->residual(points_[(first + k) % n_]);
            if (std::abs(residual[k]) <= least || residual[k] * residual[0] < 0.0) return false;
        }
        for (std::size_t k = 0; k < length; ++k) {
            const std::size_t i = (first + k) % n_;
            found_.bad[i] = 1;
            found_.corner[i] = 0;
            found_.residual[i] = -residual[k];  // the outward normal of a counter-clockwise lap is on the right
            ++found_.count;
        }
        return true;
    }

    std::span<const Vec2> points_;
    bool closed_;
    std::size_t n_;
    double floor_mm_;
    BadPoints& found_;
};

}  // namespace

std::size_t mark_bad_runs(std::span<const Vec2> points, bool closed, double floor_mm, BadPoints& found) {
    return RunFinder(points, closed, floor_mm, found).run();
}

}  // namespace cmm::fitting
