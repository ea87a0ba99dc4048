// SPDX-License-Identifier: Apache-2.0
#include "fitting/ordering.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/cyclic.hpp"
#include "fitting/gaps.hpp"
#include "fitting/lent_way.hpp"
#include "fitting/outliers.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr std::size_t least_lap_points = 16;
constexpr double duplicate_share = 0.02;     // of the median spacing: nearer than that says nothing about direction
constexpr double least_closing_share = 0.3;  // of the spacing: nearer to the first point a last one repeats it
constexpr double told_direction_mm = 0.025;  // a shorter way goes where the noise does
constexpr double back_lateral_mm = 0.015;    // noise and chord error: nearer to the stretch just measured is on it
constexpr std::size_t back_reach = 32;  // points that a scan may step back: over a run of bad ones it may lose its way
constexpr double most_misfit_mm = 6.0;  // of points that belong to a nominal
constexpr double clear_sense = 0.5;     // of the misfit of the wrong sense
constexpr double far_steps = 8.0;       // from one point to the next: a gap
constexpr std::size_t compared_steps = 4;  // on either side, that a step is compared with
constexpr std::size_t start_tries = 6;     // the first points of a scan may be bad

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The good points of the open chain and their cumulative chord lengths.
struct Chain {
    std::vector<Vec2> good;
    std::vector<char> bad;       // by usable point
    std::vector<char> repeated;  // by usable point: the scan had stepped back and measured the same stretch once more
    std::vector<double> s;
    double diagonal = 0.0;

    double step_near(std::size_t at, std::size_t reach) const {
        std::vector<double> steps;
        const std::size_t low = at > reach ? at - reach : 0, high = std::min(at + reach, good.size() - 1);
        for (std::size_t i = low; i < high; ++i)
            steps.push_back(s[i + 1] - s[i]);
        return median(steps);
    }
};

/// Whether p lies on the stretch just measured, behind its end: the scan stepped back.
bool steps_back(const Chain& chain, const Vec2& p) {
    const std::size_t n = chain.good.size();
    if (n < 4) return false;
    std::size_t before = n - 2;
    while (before > 0 && chain.s.back() - chain.s[before] < told_direction_mm)
        --before;
    if ((p - chain.good[n - 1]).dot(chain.good[n - 1] - chain.good[before]) > 0.0) return false;
    const double step = chain.step_near(n - 1, 8);
    const double lateral = std::min(back_lateral_mm, 0.3 * step);
    for (std::size_t j = n > back_reach ? n - back_reach : 1; j < n; ++j) {
        const Vec2 segment = chain.good[j] - chain.good[j - 1];
        const double length = segment.norm();
        const double along = std::clamp((p - chain.good[j - 1]).dot(segment) / length, 0.0, length);
        const double behind = chain.s.back() - (chain.s[j - 1] + along);
        if (behind > 0.5 * step && (chain.good[j - 1] + segment * (along / length) - p).norm() < lateral) return true;
    }
    return false;
}

Chain make_chain(std::span<const Vec2> points, const std::vector<std::size_t>& usable, double floor) {
    std::vector<Vec2> all;
    all.reserve(usable.size());
    for (const std::size_t i : usable)
        all.push_back(points[i]);
    Chain chain;
    chain.bad = find_clearly_bad_points(all, false, floor);
    chain.repeated.assign(all.size(), 0);
    Vec2 low = all.front(), high = low;
    for (std::size_t k = 0; k < all.size(); ++k) {
        // A bad point among repeated ones tells no place on the lap either.
        const bool among_repeated = chain.bad[k] && k > 0 && chain.repeated[k - 1];
        chain.repeated[k] = static_cast<char>(among_repeated || steps_back(chain, all[k]));
        if (chain.bad[k] || chain.repeated[k]) continue;
        chain.s.push_back(chain.good.empty() ? 0.0 : chain.s.back() + (all[k] - chain.good.back()).norm());
        chain.good.push_back(all[k]);
        low = low.cwiseMin(all[k]);
        high = high.cwiseMax(all[k]);
    }
    chain.diagonal = (high - low).norm();
    return chain;
}

/// Arc length at which the chain is back at its first point, as good[start] tells that it passes again in the same
/// direction; a negative number where it does not. Bad points beside the start turn its direction: the place is the
/// foot on the way back. That is taken in stretches of 25 um: shorter ones go where the noise does.
double back_at(const Chain& chain, std::size_t start) {
    const Vec2 place = chain.good[start];
    const double step = chain.step_near(start, 6);
    const auto beyond = [&](std::size_t from, double least) {
        std::size_t to = from + 1;
        while (to + 1 < chain.good.size() && chain.s[to] - chain.s[from] < least)
            ++to;
        return to;
    };
    const Vec2 direction = (chain.good[beyond(start, std::max(2.0 * step, told_direction_mm))] - place).normalized();
    const double lateral = std::max(0.05, 2.0 * step);
    bool was_before = false;
    for (std::size_t j = start, next = 0; j + 1 < chain.good.size(); j = next) {
        next = beyond(j, told_direction_mm);
        if (chain.s[j] - chain.s[start] < chain.diagonal) continue;
        const double length = (chain.good[next] - chain.good[j]).norm();
        const Vec2 along = (chain.good[next] - chain.good[j]) / length;
        const double foot = (place - chain.good[j]).dot(along);
        const bool passes = foot < length && (foot >= 0.0 || was_before);
        was_before = foot >= length;
        if (!passes || along.dot(direction) <= 0.0) continue;
        const double walked = std::max(foot, 0.0);
        if ((chain.good[j] + walked * along - place).norm() > lateral) continue;
        const double way = (chain.s[next] - chain.s[j]) / length;
        return chain.s[j] + way * (walked - (place - chain.good.front()).dot(along));
    }
    return -1.0;
}

/// Splits the chain where it has been round once. A second measurement of the same place lies so near to the first that
/// the two say nothing about direction, only noise: it is checked against the curve later, and not fitted. The same
/// holds for a last point that all but repeats the first.
void take_first_lap(std::span<const Vec2> points, const std::vector<std::size_t>& usable, const Chain& chain,
                    double length, Lap& lap) {
    const double least =
        least_closing_share * std::min(chain.step_near(0, 4), chain.step_near(chain.good.size() - 1, 4));
    double walked = 0.0;
    std::size_t good = 0;
    for (std::size_t k = 0; k < usable.size(); ++k) {
        const std::size_t i = usable[k];
        if (good < chain.good.size() && chain.good[good] == points[i]) walked = chain.s[good++];
        const bool again = chain.repeated[k] || (walked > length - least && !lap.index.empty());
        (again ? lap.again : lap.index).push_back(i);
    }
}

/// Of good points in order. The ends of a side alone are joined by a chord, on either side of which it may lie: then
/// the nominal tells it.
core::Result<bool> is_clockwise(std::span<const Vec2> good, double twice_area, const SectionOptions& options) {
    if (options.nominal == nullptr) return twice_area < 0.0;
    double longest_mm = 0.0, whole_mm = 0.0;
    for (std::size_t i = 0; i < good.size(); ++i) {
        const double step_mm = (good[cyclic(i + 1, good.size())] - good[i]).norm();
        longest_mm = std::max(longest_mm, step_mm);
        whole_mm += step_mm;
    }
    if (longest_mm <= most_bridged_share * whole_mm) return twice_area < 0.0;
    const auto off_mm = [&](LentWay::Sense sense) {
        return LentWay(*options.nominal, options.ball_radius_mm, good, sense).misfit_mm();
    };
    const double counter_mm = off_mm(LentWay::Sense::counter_clockwise),
                 clockwise_mm = off_mm(LentWay::Sense::clockwise);
    const double better_mm = std::min(counter_mm, clockwise_mm), worse_mm = std::max(counter_mm, clockwise_mm);
    if (better_mm < most_misfit_mm && better_mm < clear_sense * worse_mm) return clockwise_mm < counter_mm;
    return core::fail(ErrorCode::fit_not_evaluable,
                      "section: open, and the nominal does not tell on which side of the points the material lies");
}

core::Status turn_counter_clockwise(std::span<const Vec2> points, const std::vector<char>& is_bad,
                                    const SectionOptions& options, Lap& lap) {
    std::vector<Vec2> ordered;
    std::vector<std::size_t> good;
    for (std::size_t k = 0; k < lap.index.size(); ++k) {
        ordered.push_back(points[lap.index[k]]);
        if (!is_bad[lap.index[k]]) good.push_back(k);
    }
    double twice = 0.0;
    Vec2 moment = Vec2::Zero();
    const Vec2 origin = ordered[good.front()];
    for (std::size_t g = 0; g < good.size(); ++g) {
        const Vec2 a = ordered[good[g]] - origin, b = ordered[good[cyclic(g + 1, good.size())]] - origin;
        twice += cross(a, b);
        moment += cross(a, b) * (a + b);
    }
    const Vec2 middle = origin + moment / (3.0 * twice);
    const std::size_t first = *std::max_element(good.begin(), good.end(), [&](std::size_t a, std::size_t b) {
        return (ordered[a] - middle).squaredNorm() < (ordered[b] - middle).squaredNorm();
    });
    std::rotate(lap.index.begin(), lap.index.begin() + static_cast<std::ptrdiff_t>(first), lap.index.end());
    std::vector<Vec2> in_order;
    for (const std::size_t k : good)
        in_order.push_back(ordered[k]);
    const auto clockwise = is_clockwise(in_order, twice, options);
    if (!clockwise) return tl::unexpected(clockwise.error());
    lap.was_clockwise = *clockwise;
    if (lap.was_clockwise) std::reverse(lap.index.begin() + 1, lap.index.end());
    return {};
}

/// A probe that trembles along its path now and then measures a place behind the one before: such two change places, so
/// that the order is that along the curve.
void untangle(std::span<const Vec2> points, std::vector<std::size_t>& order) {
    constexpr int most_passes = 4;
    constexpr double clear_step_back = 0.1;  // cosine
    const std::size_t n = order.size();
    const auto at = [&](std::size_t k) -> const Vec2& { return points[order[cyclic(k, n)]]; };
    bool any = n > 4;
    for (int pass = 0; any && pass < most_passes; ++pass) {
        any = false;
        for (std::size_t k = 0; k < n; ++k) {
            const Vec2 in = at(k + 1) - at(k), step = at(k + 2) - at(k + 1), out = at(k + 3) - at(k + 2);
            if (step.dot(in) >= 0.0 && step.dot(out) >= 0.0) continue;
            // Over a gap the next point may lie anywhere; a step is one beside two that are far shorter.
            const bool behind_gap = in.norm() > far_steps * std::max(step.norm(), out.norm());
            const bool before_gap = out.norm() > far_steps * std::max(step.norm(), in.norm());
            const Vec2 along = behind_gap ? out : before_gap ? in : Vec2(at(k + 3) - at(k));
            // A step between two bad points goes to the side, whichever of them came first.
            if (step.dot(along) >= -clear_step_back * step.norm() * along.norm()) continue;
            std::swap(order[cyclic(k + 1, n)], order[cyclic(k + 2, n)]);
            any = true;
        }
    }
}

}  // namespace

std::vector<std::size_t> usable_points(std::span<const Vec2> points, std::span<const char> excluded,
                                       std::vector<char>& duplicate) {
    duplicate.assign(points.size(), 0);
    std::vector<std::size_t> wanted;
    std::vector<double> steps;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (excluded[i] || !is_finite(points[i])) continue;
        if (!wanted.empty()) steps.push_back((points[i] - points[wanted.back()]).norm());
        wanted.push_back(i);
    }
    const double least = std::max(1e-6, duplicate_share * median(steps));
    std::vector<std::size_t> usable;
    for (const std::size_t i : wanted) {
        if (!usable.empty() && (points[i] - points[usable.back()]).norm() < least) {
            duplicate[i] = 1;
        } else {
            usable.push_back(i);
        }
    }
    while (usable.size() > 1 && (points[usable.back()] - points[usable.front()]).norm() < 1e-6) {
        duplicate[usable.back()] = 1;
        usable.pop_back();
    }
    return usable;
}

core::Result<Lap> order_lap(std::span<const Vec2> points, const std::vector<std::size_t>& usable,
                            const SectionOptions& options) {
    if (usable.size() < least_lap_points)
        return core::fail(ErrorCode::fit_not_evaluable, "section: needs " + std::to_string(least_lap_points) +
                                                            " different points, got " + std::to_string(usable.size()));
    const Chain chain = make_chain(points, usable, options.reject_floor_mm);
    double lap_length = -1.0;
    for (std::size_t start = 0; start < start_tries && lap_length < 0.0; ++start)
        lap_length = back_at(chain, start);

    Lap lap;
    if (lap_length > 0.0) {
        take_first_lap(points, usable, chain, lap_length, lap);
    } else {
        for (std::size_t k = 0; k < usable.size(); ++k)
            (chain.repeated[k] ? lap.again : lap.index).push_back(usable[k]);
    }
    std::vector<char> is_bad(points.size(), 0);
    for (std::size_t k = 0; k < usable.size(); ++k)
        is_bad[usable[k]] = chain.bad[k];
    if (auto status = turn_counter_clockwise(points, is_bad, options, lap); !status)
        return tl::unexpected(status.error());
    untangle(points, lap.index);
    return lap;
}

void join_pass(std::span<const Vec2> points, const std::vector<std::size_t>& later, double reject_floor_mm, Lap& lap) {
    std::vector<Vec2> ordered;
    for (const std::size_t i : lap.index)
        ordered.push_back(points[i]);
    const auto bad = find_clearly_bad_points(ordered, true, reject_floor_mm);
    // A bad point stays where its predecessor is.
    std::vector<Vec2> corners;
    std::vector<double> breaks{0.0};
    std::vector<std::pair<double, std::size_t>> along;
    for (std::size_t k = 0; k < ordered.size(); ++k) {
        if (!bad[k]) {
            if (!corners.empty()) breaks.push_back(breaks.back() + (ordered[k] - corners.back()).norm());
            corners.push_back(ordered[k]);
        }
        along.emplace_back(breaks.back(), lap.index[k]);
    }
    breaks.push_back(breaks.back() + (corners.front() - corners.back()).norm());
    std::vector<PiecewiseCubic::Piece> sides;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        const Vec2 side = corners[(k + 1) % corners.size()] - corners[k];
        sides.push_back({corners[k], side.normalized(), Vec2::Zero(), Vec2::Zero()});
    }
    const std::size_t n = corners.size();
    const auto is_gap = [&](std::size_t side) {
        std::vector<double> steps;
        for (std::size_t k = 1; k <= compared_steps; ++k)
            for (const std::size_t beside : {cyclic(side + k, n), cyclic(side + n - k, n)})
                steps.push_back(breaks[beside + 1] - breaks[beside]);
        return breaks[side + 1] - breaks[side] > far_steps * median(steps);
    };
    const ClosestPointIndex polygon(PiecewiseCubic(breaks, std::move(sides), true));
    std::map<std::size_t, std::vector<std::size_t>> in_gaps;  // by side
    std::size_t span = 0;
    for (const std::size_t i : later) {
        const CurveFoot foot = polygon.closest(points[i], span);
        span = foot.span;
        const std::size_t before = cyclic(span + n - 1, n), behind = cyclic(span + 1, n);
        if (is_gap(span)) {
            in_gaps[span].push_back(i);
        } else if (foot.t <= breaks[span] && is_gap(before)) {
            in_gaps[before].push_back(i);
        } else if (foot.t >= breaks[span + 1] && is_gap(behind)) {
            in_gaps[behind].push_back(i);
        } else {
            along.emplace_back(foot.t, i);
        }
    }
    // The straight line over a gap says nothing of the order of points far beside it: they keep their own.
    for (auto& [side, in_gap] : in_gaps) {
        const Vec2 over = corners[cyclic(side + 1, n)] - corners[side];
        if ((points[in_gap.back()] - points[in_gap.front()]).dot(over) < 0.0)
            std::reverse(in_gap.begin(), in_gap.end());
        for (const std::size_t i : in_gap)
            along.emplace_back(breaks[side], i);
    }
    std::stable_sort(along.begin(), along.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    constexpr double same_place_mm = 1e-6;
    lap.index.clear();
    for (const auto& [t, i] : along) {
        const bool same = !lap.index.empty() && (points[i] - points[lap.index.back()]).norm() < same_place_mm;
        (same ? lap.again : lap.index).push_back(i);
    }
    untangle(points, lap.index);
}

}  // namespace cmm::fitting
