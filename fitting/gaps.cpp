// SPDX-License-Identifier: Apache-2.0
#include "fitting/gaps.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

#include "core/text.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/lent_way.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t local_steps = 8;  // steps on either side that tell how densely the points lie
constexpr std::size_t bridge_points = 12;
constexpr double bridge_sigma_share = 0.02;  // of the gap's width
constexpr double least_gap_balls = 0.25;     // of the ball radius: round what is narrower it turns by a quarter at most
constexpr double most_bridged_turn_rad = 1.2;                 // from before a gap to behind it: more is an edge
constexpr std::size_t least_points_in_part = 40;              // of a section that misses an edge or a side
constexpr double most_edge_turn_rad = 4.0, edge_reach = 2.0;  // in widths of the gap

/// Median of the steps first, first + stride, ... of a closed sequence.
double median_from(const std::vector<double>& steps, std::size_t first, std::size_t stride) {
    std::array<double, local_steps> near{};
    for (std::size_t k = 0; k < local_steps; ++k)
        near[k] = steps[(first + k * stride) % steps.size()];
    std::nth_element(near.begin(), near.begin() + local_steps / 2, near.end());
    return near[local_steps / 2];
}

std::vector<double> steps_of(std::span<const Vec2> points) {
    const std::size_t n = points.size();
    std::vector<double> steps(n);
    for (std::size_t k = 0; k < n; ++k)
        steps[k] = (points[cyclic(k + 1, n)] - points[k]).norm();
    return steps;
}

/// Unit vector from points[first] into the stretch first, first + stride, ...: the tangent there of the parabola
/// through the eight that follow.
Vec2 into_stretch(std::span<const Vec2> points, std::size_t first, std::size_t stride) {
    const auto off = [&](std::size_t k) -> Vec2 {
        return points[(first + k * stride) % points.size()] - points[first];
    };
    const Vec2 far = off(local_steps).normalized();
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Vec2 moment = Vec2::Zero();
    for (std::size_t k = 1; k <= local_steps; ++k) {
        const double along = off(k).dot(far);
        const Vec2 powers(along, along * along);
        normal += powers * powers.transpose();
        moment += powers * cross(far, off(k));
    }
    const double slope = normal.ldlt().solve(moment).x();
    return (far + slope * left_of(far)).normalized();
}

/// The way over a gap: Hermite's cubic, as fast at its ends as the one that is next to an arc of so much turn.
class Way {
  public:
    Way(std::span<const Vec2> points, std::size_t before, std::size_t behind)
        : from_(points[before]),
          to_(points[behind]),
          in_(-into_stretch(points, before, points.size() - 1)),
          out_(into_stretch(points, behind, 1)),
          turn_rad_(std::abs(turn_angle(in_, to_ - from_)) + std::abs(turn_angle(to_ - from_, out_))) {
        const double quarter = std::cos(std::min(0.25 * turn_rad_, 1.0));
        speed_mm_ = width_mm() / (quarter * quarter);
    }

    double width_mm() const { return (to_ - from_).norm(); }
    /// From before the gap to its chord and on to behind it.
    double turn_rad() const { return turn_rad_; }
    bool turns_left() const { return turn_angle(in_, to_ - from_) > 0.0 && turn_angle(to_ - from_, out_) > 0.0; }
    std::vector<SupposedPoint> evenly() const {
        std::vector<SupposedPoint> places;
        for (std::size_t k = 1; k <= bridge_points; ++k)
            places.push_back({at(static_cast<double>(k) / (bridge_points + 1)), bridge_sigma_share * width_mm()});
        return places;
    }

  private:
    Vec2 at(double w) const {
        const double v = 1.0 - w;
        return v * v * (1.0 + 2.0 * w) * from_ + w * w * (1.0 + 2.0 * v) * to_ +
               speed_mm_ * w * v * (v * in_ - w * out_);
    }

    Vec2 from_, to_, in_, out_;
    double turn_rad_, speed_mm_ = 0.0;
};

/// An edge where the hints have one, and no more than what is round it.
bool is_edge(std::span<const Vec2> points, const Gap& gap, const Way& way, const SectionOptions& options) {
    const Vec2 middle = 0.5 * (points[gap.before] + points[gap.behind]);
    const auto near = [&](const std::optional<Vec2>& hint) {
        return hint && (*hint - middle).norm() < edge_reach * way.width_mm();
    };
    return way.turns_left() && way.turn_rad() <= most_edge_turn_rad && (near(options.le_hint) || near(options.te_hint));
}

std::string unmeasured(std::span<const Vec2> points, const Gap& gap) {
    const auto at = [](const Vec2& p) { return "(" + core::fixed(p.x(), 3) + ", " + core::fixed(p.y(), 3) + ")"; };
    const std::string but_bad = gap.bad > 0 ? " but bad points (" + std::to_string(gap.bad) + ")" : "";
    return "nothing was measured between " + at(points[gap.before]) + " and " + at(points[gap.behind]) + " mm" +
           but_bad + ", " + core::fixed(100.0 * gap.share, 0) + " % of the way round, where it turns by " +
           core::fixed(gap.turn_rad * 180.0 / std::numbers::pi, 0) + " degrees";
}

/// A ball that goes round an edge makes a way; where the next point is on the other side of it, nobody measured it.
bool may_skip_edge(double step_mm, double ball_radius_mm) {
    return ball_radius_mm > 0.0 && step_mm >= ball_radius_mm;
}
bool skips_edge(const Way& way) {
    return way.turn_rad() > most_bridged_turn_rad && way.turns_left();
}

}  // namespace

std::vector<Gap> find_gaps(std::span<const Vec2> points, const SectionOptions& options) {
    const std::size_t n = points.size();
    std::vector<Gap> gaps;
    if (n < 2 * local_steps) return gaps;
    const std::vector<double> steps = steps_of(points);
    const double factor = options.gap_factor, least_mm = least_gap_balls * options.ball_radius_mm;
    const auto is_far = [&](std::size_t k) {
        if (steps[k] <= least_mm || steps[k] <= factor * std::min(steps[cyclic(k + n - 1, n)], steps[cyclic(k + 1, n)]))
            return false;
        return steps[k] > factor * std::max(median_from(steps, k + 1, 1), median_from(steps, k + n - 1, n - 1));
    };
    const double whole_mm = std::accumulate(steps.begin(), steps.end(), 0.0);
    for (std::size_t k = 0; k < n; ++k) {
        const bool far = is_far(k);
        if (!far && !may_skip_edge(steps[k], options.ball_radius_mm)) continue;
        const Way way(points, k, cyclic(k + 1, n));
        if (!far && !skips_edge(way)) continue;
        gaps.push_back({k, cyclic(k + 1, n), steps[k] / whole_mm, way.turn_rad(), 0});
    }
    return gaps;
}

bool Gap::on_side() const {
    return turn_rad <= most_bridged_turn_rad && share <= most_bridged_share;
}

core::Result<Bridges> bridges_over(std::span<const Vec2> points, std::span<const Gap> gaps,
                                   const SectionOptions& options) {
    Bridges bridges;
    std::optional<LentWay> lent;
    for (const Gap& gap : gaps) {
        const Way way(points, gap.before, gap.behind);
        if (gap.on_side()) {
            bridges.over.push_back({gap.before, way.evenly()});
            continue;
        }
        const std::string what = unmeasured(points, gap);
        if (points.size() < least_points_in_part)
            return core::fail(core::ErrorCode::fit_not_evaluable,
                              "section: open, " + what + ", and too few points beside it (" +
                                  std::to_string(points.size()) + " of " + std::to_string(least_points_in_part) + ")");
        if (options.nominal != nullptr) {
            if (!lent) lent.emplace(*options.nominal, options.ball_radius_mm, points);
            bridges.over.push_back({gap.before, lent->between(points[gap.before], points[gap.behind])});
        } else if (gap.share <= most_bridged_share && is_edge(points, gap, way, options)) {
            bridges.over.push_back({gap.before, way.evenly()});
        } else {
            return core::fail(core::ErrorCode::fit_not_evaluable,
                              "section: open, " + what + "; without a nominal nothing tells the way there");
        }
        bridges.missing += (bridges.missing.empty() ? "" : "; ") + what;
    }
    return bridges;
}

}  // namespace cmm::fitting
