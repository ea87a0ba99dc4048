// SPDX-License-Identifier: Apache-2.0
#include "fitting/ordering.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "core/text.hpp"
#include "fitting/outliers.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr std::size_t least_points = 16;
constexpr double duplicate_share = 0.02;  // of the median spacing: nearer than that says nothing about direction
constexpr std::size_t start_tries = 6;    // the first points of a scan may be bad

double median(std::vector<double> values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// The good points of the open chain and their cumulative chord lengths.
struct Chain {
    std::vector<Vec2> good;
    std::vector<char> bad;  // by usable point
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

Chain make_chain(std::span<const Vec2> points, const std::vector<std::size_t>& usable, double floor) {
    std::vector<Vec2> all;
    all.reserve(usable.size());
    for (const std::size_t i : usable)
        all.push_back(points[i]);
    Chain chain;
    chain.bad = find_bad_points(all, false, floor).bad;
    Vec2 low = all.front(), high = low;
    for (std::size_t k = 0; k < all.size(); ++k) {
        if (chain.bad[k]) continue;
        chain.s.push_back(chain.good.empty() ? 0.0 : chain.s.back() + (all[k] - chain.good.back()).norm());
        chain.good.push_back(all[k]);
        low = low.cwiseMin(all[k]);
        high = high.cwiseMax(all[k]);
    }
    chain.diagonal = (high - low).norm();
    return chain;
}

/// Arc length at which the chain passes good[start] again in the same direction, or a negative number.
double passes_again(const Chain& chain, std::size_t start) {
    const Vec2 origin = chain.good[start];
    const double step = chain.step_near(start, 6);
    std::size_t ahead = start + 1;
    while (ahead + 1 < chain.good.size() && chain.s[ahead] - chain.s[start] < 2.0 * step)
        ++ahead;
    const Vec2 direction = (chain.good[ahead] - origin).normalized();
    const double lateral = std::max(0.05, 2.0 * step);
    for (std::size_t j = start; j + 1 < chain.good.size(); ++j) {
        if (chain.s[j] - chain.s[start] < chain.diagonal) continue;
        const Vec2 before = chain.good[j] - origin, after = chain.good[j + 1] - origin;
        const double x0 = before.dot(direction), x1 = after.dot(direction);
        if (x0 > 0.0 || x1 <= 0.0) continue;
        const double share = -x0 / (x1 - x0);
        if (std::abs(cross(direction, before + share * (after - before))) > lateral) continue;
        if ((after - before).normalized().dot(direction) < 0.5) continue;
        return chain.s[j] + share * (chain.s[j + 1] - chain.s[j]) - chain.s[start];
    }
    return -1.0;
}

/// Arc length of each usable point on the lap [0, lap), lap measured from the chain's beginning; a monotone walk,
/// because a point of the overlap must not be taken to the opposite side of a thin edge.
std::vector<double> places_on_lap(std::span<const Vec2> points, const std::vector<std::size_t>& usable,
                                  const Chain& chain, double lap) {
    std::vector<double> place(usable.size());
    std::size_t at = 0;    // segment of the chain's first lap
    std::size_t last = 0;  // its last segment
    while (last + 2 < chain.good.size() && chain.s[last + 1] < lap)
        ++last;
    double walked = 0.0;  // by the good points themselves, to know in which lap we are
    std::size_t good = 0;
    for (std::size_t k = 0; k < usable.size(); ++k) {
        const Vec2& p = points[usable[k]];
        if (good < chain.good.size() && chain.good[good] == p) walked = chain.s[good++];
        if (walked < lap) {
            at = good > 0 ? good - 1 : 0;
            const std::size_t to = std::min(at + 1, chain.good.size() - 1);
            const Vec2 segment = chain.good[to] - chain.good[at];
            const double length = segment.norm();
            // A good point is at its own place; a bad one is projected between its good neighbours.
            const double along =
                length > 0.0 ? std::clamp((p - chain.good[at]).dot(segment) / length, 0.0, length) : 0.0;
            place[k] = p == chain.good[at] ? chain.s[at] : chain.s[at] + along;
            if (place[k] >= lap) place[k] -= lap;
            continue;
        }
        if (k == 0 || at + 1 > last || place[k - 1] > chain.s[last]) at = 0;
        const auto project = [&](std::size_t j, double& along) {
            const Vec2 segment = chain.good[j + 1] - chain.good[j];
            const double length = segment.norm();
            along = length > 0.0 ? std::clamp((p - chain.good[j]).dot(segment) / length, 0.0, length) : 0.0;
            return (chain.good[j] + segment * (length > 0.0 ? along / length : 0.0) - p).squaredNorm();
        };
        double along = 0.0, best = project(at, along);
        for (std::size_t j = at + 1; j <= std::min(last, at + 12); ++j) {
            double candidate = 0.0;
            if (const double d = project(j, candidate); d < best) {
                best = d;
                along = candidate;
                at = j;
            }
        }
        place[k] = std::fmod(chain.s[at] + along, lap);
    }
    return place;
}

void turn_counter_clockwise(std::span<const Vec2> points, const std::vector<char>& is_bad, Lap& lap) {
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
        const Vec2 a = ordered[good[g]] - origin, b = ordered[good[(g + 1) % good.size()]] - origin;
        twice += cross(a, b);
        moment += cross(a, b) * (a + b);
    }
    const Vec2 middle = origin + moment / (3.0 * twice);
    const std::size_t first = *std::max_element(good.begin(), good.end(), [&](std::size_t a, std::size_t b) {
        return (ordered[a] - middle).squaredNorm() < (ordered[b] - middle).squaredNorm();
    });
    std::rotate(lap.index.begin(), lap.index.begin() + static_cast<std::ptrdiff_t>(first), lap.index.end());
    lap.was_clockwise = twice < 0.0;
    if (lap.was_clockwise) std::reverse(lap.index.begin() + 1, lap.index.end());
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
                            double closing_gap_factor, double reject_floor_mm) {
    if (usable.size() < least_points)
        return core::fail(ErrorCode::fit_not_evaluable, "section: needs " + std::to_string(least_points) +
                                                            " different points, got " + std::to_string(usable.size()));
    const Chain chain = make_chain(points, usable, reject_floor_mm);
    double lap_length = -1.0;
    for (std::size_t start = 0; start < start_tries && lap_length < 0.0; ++start)
        lap_length = passes_again(chain, start);

    Lap lap;
    lap.index = usable;
    if (lap_length > 0.0) {
        const std::vector<double> place = places_on_lap(points, usable, chain, lap_length);
        std::vector<std::size_t> by_place(usable.size());
        std::iota(by_place.begin(), by_place.end(), std::size_t{0});
        std::stable_sort(by_place.begin(), by_place.end(),
                         [&](std::size_t a, std::size_t b) { return place[a] < place[b]; });
        for (std::size_t k = 0; k < by_place.size(); ++k)
            lap.index[k] = usable[by_place[k]];
        lap.overlap =
            static_cast<std::size_t>(chain.s.end() - std::lower_bound(chain.s.begin(), chain.s.end(), lap_length));
    } else {
        const double gap = (chain.good.front() - chain.good.back()).norm();
        const double step = std::max(chain.step_near(0, 8), chain.step_near(chain.good.size() - 1, 8));
        if (gap > closing_gap_factor * step)
            return core::fail(ErrorCode::fit_not_evaluable, "section: open, its ends are " + core::length_text(gap) +
                                                                " apart where the points are " +
                                                                core::length_text(step) + " apart");
    }
    std::vector<char> is_bad(points.size(), 0);
    for (std::size_t k = 0; k < usable.size(); ++k)
        is_bad[usable[k]] = chain.bad[k];
    turn_counter_clockwise(points, is_bad, lap);
    return lap;
}

}  // namespace cmm::fitting
