// SPDX-License-Identifier: Apache-2.0
#include "fitting/coarse_runs.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

constexpr std::ptrdiff_t most_good_between = 4;  // bad points that are judged together
constexpr std::ptrdiff_t longest_coarse_run = 30;
constexpr std::ptrdiff_t judged_beside = 5;       // good points a side: only half of a bad run may have been found
constexpr std::ptrdiff_t only_compared = 5;       // points beyond these
constexpr std::ptrdiff_t farthest_compared = 32;  // from the run
constexpr std::ptrdiff_t near_arc = 3;            // points from each of the run to one on the arc
constexpr std::size_t fewest_on_arc = 4;          // at the two ends of a bad run the way bends sharply, too
constexpr std::size_t fewest_bent_back = 3;       // on a concave side
constexpr double coarse_rad = 0.1;                // from step to step
constexpr double as_sharply = 1.06;               // as the arc
constexpr double as_far_back = 1.3;               // as the concave side
constexpr double part_of_arc = 0.4;               // of its curvature: a point on it, or at its end
constexpr double noise_factor = 2.0;              // standard deviations of a curvature
constexpr double most_noise = 0.3;                // of the arc's curvature

/// Of the way through three points, at the middle one.
struct PointBend {
    double turn_rad, curvature, sd;

    PointBend(const Vec2& a, const Vec2& b, const Vec2& c, double sigma) {
        const Vec2 in = b - a, out = c - b;
        const double before = 1.0 / std::max(in.norm(), 1e-9), after = 1.0 / std::max(out.norm(), 1e-9);
        const double per_step = 2.0 * before * after / (before + after);
        turn_rad = turn_angle(in, out);
        curvature = turn_rad * per_step;
        sd = sigma * per_step * std::sqrt(before * before + after * after + (before + after) * (before + after));
    }
    void mirror() {
        turn_rad = -turn_rad;
        curvature = -curvature;
    }
};

/// From first to last bad points with a few good ones between them, and how the way bends there if all are good.
class CoarseRun {
  public:
    CoarseRun(const ChainState& chain, std::ptrdiff_t first, std::ptrdiff_t last) : length_(last - first + 1) {
        std::vector<Vec2> way = good_points(chain, first, -1);
        const std::vector<Vec2> after = good_points(chain, last, 1);
        if (way.size() < around || after.size() < around || length_ + 2 * farthest_compared > chain.size()) return;
        std::reverse(way.begin(), way.end());
        for (std::ptrdiff_t i = first; i <= last; ++i)
            way.push_back(chain.point(i));
        way.insert(way.end(), after.begin(), after.end());
        double turn = 0.0;
        for (std::size_t k = 1; k + 1 < way.size(); ++k) {
            bends_.emplace_back(way[k - 1], way[k], way[k + 1], chain.least_sigma());
            turn += bends_.back().turn_rad;
        }
        if (turn > 0.0) return;
        for (PointBend& bend : bends_)
            bend.mirror();
    }

    /// Whether the way bends no other way and no more sharply than around it, and all that is plain among the noise.
    bool is_form() {
        if (bends_.empty() || of_arc(&PointBend::turn_rad) < coarse_rad) return false;
        const double arc = of_arc(&PointBend::curvature), least = as_far_back * std::min(0.0, of_concave_side());
        const auto is_like_others = [&](const PointBend& bend) {
            const double noise = noise_factor * bend.sd;
            return noise <= most_noise * arc && bend.curvature >= least - noise &&
                   bend.curvature <= as_sharply * arc + noise;
        };
        const auto is_on_arc = [&](const PointBend& bend) { return bend.curvature >= part_of_arc * arc; };
        for (Iterator bend = before(0); bend != behind(0); ++bend)
            if (std::none_of(bend - near_arc, bend + near_arc + 1, is_on_arc)) return false;
        return std::all_of(before(judged_beside), behind(judged_beside), is_like_others);
    }

  private:
    using Iterator = std::vector<PointBend>::const_iterator;
    static constexpr std::size_t around = judged_beside + only_compared + 1;

    /// From the group on, the nearest first.
    static std::vector<Vec2> good_points(const ChainState& chain, std::ptrdiff_t from, std::ptrdiff_t step) {
        std::vector<Vec2> found;
        for (std::ptrdiff_t at = from + step; std::abs(at - from) < farthest_compared && chain.exists(at); at += step) {
            if (chain.state(at) != PointState::good) continue;
            found.push_back(chain.point(at));
            if (found.size() == around) break;
        }
        return found;
    }

    /// So many points before the group, and behind it.
    Iterator before(std::ptrdiff_t points) const { return bends_.begin() + judged_beside + only_compared - points; }
    Iterator behind(std::ptrdiff_t points) const {
        return bends_.begin() + judged_beside + only_compared + length_ + points;
    }

    /// What so many points reach as make an arc.
    double of_arc(double PointBend::*value) {
        work_.clear();
        for (const PointBend& bend : bends_)
            work_.push_back(bend.*value);
        return nth_smallest(work_, work_.size() - fewest_on_arc);
    }

    /// What is plainly bent back: where points are close their noise bends the way as sharply as a bad run does.
    double of_concave_side() {
        work_.clear();
        for (auto bend = bends_.cbegin(); bend != bends_.cend(); ++bend)
            if (bend < before(judged_beside) || bend >= behind(judged_beside))
                work_.push_back(bend->curvature + noise_factor * bend->sd);
        return nth_smallest(work_, fewest_bent_back - 1);
    }

    std::ptrdiff_t length_;
    std::vector<PointBend> bends_;  // counter-clockwise; empty where there are too few points
    std::vector<double> work_;
};

bool is_still_bad(const ChainState& chain, std::ptrdiff_t i) {
    return chain.exists(i) && chain.state(i) == PointState::bad;
}

/// The last of the bad points that are judged with a first one.
std::ptrdiff_t end_of_coarse_run(const ChainState& chain, std::ptrdiff_t first) {
    std::ptrdiff_t last = first;
    for (std::ptrdiff_t i = first; i - last <= most_good_between + 1 && last - first < longest_coarse_run; ++i)
        if (is_still_bad(chain, i)) last = i;
    return last;
}

bool begins_coarse_run(const ChainState& chain, std::ptrdiff_t i) {
    if (!is_still_bad(chain, i)) return false;
    for (std::ptrdiff_t apart = 1; apart <= most_good_between + 1; ++apart)
        if (is_still_bad(chain, i - apart)) return false;
    return true;
}

}  // namespace

void free_coarse_runs(ChainState& chain) {
    if (!chain.any_bad()) return;
    for (std::ptrdiff_t first = 0; first < chain.size(); ++first) {
        if (!begins_coarse_run(chain, first)) continue;
        const std::ptrdiff_t last = end_of_coarse_run(chain, first);
        if (last - first >= longest_coarse_run || !CoarseRun(chain, first, last).is_form()) continue;
        for (std::ptrdiff_t i = first; i <= last; ++i)
            chain.state(i) = PointState::good;
        const std::ptrdiff_t by = 3 * chain.stride(first);
        chain.test(first - by, last + by);
    }
}

}  // namespace cmm::fitting
