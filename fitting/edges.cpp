// SPDX-License-Identifier: Apache-2.0
#include "fitting/edges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/cyclic.hpp"
#include "fitting/section.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double edge_turn_rad = 2.0 * std::numbers::pi / 3.0;
constexpr double rounding_rad = 1e-9;
constexpr double longest_share = 0.25;  // of the perimeter; a circle turns 120 degrees in a third of it
constexpr double apart_share = 0.2;     // the two edges' middles are at least this share of the perimeter apart
constexpr std::size_t coarse_contour_points = 600;
constexpr double transition_curvature = 0.4;  // of the edge's mean curvature

/// Arc length and unwrapped direction of the normal at the points, as if the contour went on for ever: index n is point
/// 0 again, one perimeter and one turn later.
class Track {
  public:
    explicit Track(std::span<const OffsetPoint> contour) : n_(contour.size()) {
        marks_.reserve(n_ + 1);
        Mark mark = marks_.emplace_back();
        for (std::size_t i = 1; i <= n_; ++i) {
            const OffsetPoint& from = contour[i - 1];
            const OffsetPoint& to = contour[i < n_ ? i : 0];
            const double turn = turn_between(from.normal, to.normal);
            mark.s += (to.position - from.position).norm();
            mark.angle += turn;
            mark.forth += std::max(turn, 0.0);
            marks_.push_back(mark);
        }
    }

    std::size_t size() const { return n_; }
    double perimeter() const { return marks_[n_].s; }
    double s(std::size_t i) const { return on_any_lap(&Mark::s, i); }
    double angle(std::size_t i) const { return on_any_lap(&Mark::angle, i); }
    /// What the direction has gone forth up to there, without where it went back: from i to j it turns by no more.
    double forth(std::size_t i) const { return on_any_lap(&Mark::forth, i); }
    double angle_at(double where) const {
        const std::size_t behind = at(where), before = behind - 1;
        const double share = (s(behind) - where) / (s(behind) - s(before));
        return angle(behind) - share * (angle(behind) - angle(before));
    }
    /// The first index at or beyond an arc length >= 0.
    std::size_t at(double where) const {
        const auto laps = static_cast<std::size_t>(where / perimeter());
        const double inside = where - static_cast<double>(laps) * perimeter();
        const auto found = std::lower_bound(marks_.begin(), marks_.end(), inside,
                                            [](const Mark& mark, double s) { return mark.s < s; });
        return laps * n_ + static_cast<std::size_t>(found - marks_.begin());
    }

  private:
    struct Mark {
        double s = 0.0, angle = 0.0, forth = 0.0;
    };
    /// The laps are few, and subtracting is cheaper than dividing.
    double on_any_lap(double Mark::*value, std::size_t i) const {
        double before = 0.0;
        for (; i >= n_; i -= n_)
            before += marks_[n_].*value;
        return before + marks_[i].*value;
    }

    std::size_t n_;
    std::vector<Mark> marks_;
};

struct Window {
    std::size_t begin = 0, end = 0;  // begin in the second lap of the track or next to it
    double length = 0.0;
};

/// The shortest arc that turns by 120 degrees, at least `apart` from `other`. Texture makes the direction go back and
/// forth, so two running ends only tell where no arc has turned so far; coarse passes over every few points bound the
/// length and find the place, a fine one the arc.
std::optional<Window> sharpest(const Track& track, const std::optional<Window>& other) {
    const std::size_t n = track.size(), stride = std::max<std::size_t>(1, n / coarse_contour_points);
    std::optional<Window> best;
    double limit = longest_share * track.perimeter();
    const auto try_from = [&](std::size_t i, std::size_t first, std::size_t step) {
        const double s = track.s(i), angle = track.angle(i);
        std::size_t j = first;
        while (track.s(j) - s < limit && track.angle(j) - angle < edge_turn_rad)
            j += step;
        const double length = track.s(j) - s;
        if (length >= limit || track.angle(j) - angle < edge_turn_rad) return;
        if (other) {
            const double middle = 0.5 * (s + track.s(j)), theirs = 0.5 * (track.s(other->begin) + track.s(other->end));
            if (std::abs(std::remainder(middle - theirs, track.perimeter())) < apart_share * track.perimeter()) return;
        }
        limit = length;
        best = Window{i, j, length};
    };
    const auto pass = [&](std::size_t from, std::size_t to, std::size_t step) {
        std::size_t j = from;
        for (std::size_t i = from; i < to; i += step) {
            const double turned = track.forth(i) + edge_turn_rad - rounding_rad, farthest = track.s(i) + limit;
            j = std::max(j, i + step);
            while (track.s(j) < farthest && track.forth(j) < turned)
                j += step;
            if (track.s(j) < farthest) try_from(i, j, step);
        }
    };
    pass(0, n, 8 * stride);
    pass(0, n, stride);
    if (!best) return best;
    best->begin += n;
    best->end += n;
    if (stride == 1) return best;
    const std::size_t around = best->begin;
    limit *= 1.0 + 1e-9;
    pass(around - stride, around + stride + 1, 1);
    return best;
}

EdgeRegion region_of(const Track& track, const Window& window) {
    EdgeRegion region;
    region.scale_mm = std::max(window.length, 1e-6) / edge_turn_rad;
    const double lag = 0.35 * region.scale_mm;
    const double least = transition_curvature / region.scale_mm * lag;
    const double farthest = 4.0 * region.scale_mm;
    const std::size_t middle = track.at(0.5 * (track.s(window.begin) + track.s(window.end)));

    std::size_t end = middle, ahead = middle;
    for (; track.s(end) - track.s(middle) < farthest; ++end) {
        while (track.s(ahead) < track.s(end) + lag)
            ++ahead;
        if (end >= window.end && track.angle(ahead) - track.angle(end) < least) break;
    }
    std::size_t begin = middle, behind = middle;
    for (; track.s(middle) - track.s(begin) < farthest; --begin) {
        while (track.s(behind) > track.s(begin) - lag)
            --behind;
        if (begin <= window.begin && track.angle(begin) - track.angle(behind) < least) break;
    }
    // The sides are taken a little away from the edge, where they hardly turn: their normals are then stable.
    const double away = 2.0 * region.scale_mm;
    const double halfway = 0.5 * (track.angle_at(track.s(begin) - away) + track.angle_at(track.s(end) + away));
    std::size_t nose = begin;
    while (nose < end && track.angle(nose) < halfway)
        ++nose;
    const double step = track.angle(nose) - track.angle(nose - 1);
    region.nose_share = step > 0.0 ? std::clamp((track.angle(nose) - halfway) / step, 0.0, 1.0) : 0.0;

    const std::size_t n = track.size();
    region.begin = begin % n;
    region.end = end % n;
    region.middle = middle % n;
    region.nose = nose % n;
    return region;
}

bool first_leads(const Vec2& first, const Vec2& second, double first_scale, double second_scale,
                 const std::optional<Vec2>& le_hint, const std::optional<Vec2>& te_hint) {
    if (!le_hint && !te_hint) return first_scale >= second_scale;
    double as_named = 0.0, swapped = 0.0;
    if (le_hint) {
        as_named += (first - *le_hint).norm();
        swapped += (second - *le_hint).norm();
    }
    if (te_hint) {
        as_named += (second - *te_hint).norm();
        swapped += (first - *te_hint).norm();
    }
    return as_named <= swapped;
}

/// The camber bulges to the side of the chord on which the section's centre of area lies.
bool bulges_after(std::span<const OffsetPoint> contour, const Vec2& le, const Vec2& te) {
    double twice = 0.0;
    Vec2 moment = Vec2::Zero();
    Vec2 a = contour.back().position - le;
    for (const OffsetPoint& point : contour) {
        const Vec2 b = point.position - le;
        twice += cross(a, b);
        moment += cross(a, b) * (a + b);
        a = b;
    }
    // Counter-clockwise from the LE runs the side on the right of the chord direction LE -> TE.
    return cross(te - le, Vec2(moment / (3.0 * twice))) <= 0.0;
}

}  // namespace

Vec2 nose_of(const EdgeRegion& region, std::span<const OffsetPoint> contour) {
    const Vec2& behind = contour[region.nose].position;
    return behind +
           region.nose_share * (contour[cyclic(region.nose + contour.size() - 1, contour.size())].position - behind);
}

bool holds(const EdgeRegion& region, std::size_t i) {
    return region.begin <= region.end ? i >= region.begin && i <= region.end : i >= region.begin || i <= region.end;
}

core::Result<BladeEdges> find_edges(std::span<const OffsetPoint> contour, const std::optional<Vec2>& le_hint,
                                    const std::optional<Vec2>& te_hint) {
    if (contour.size() < 16) return core::fail(ErrorCode::fit_not_evaluable, "edges: too few contour points");
    const Track track(contour);
    const auto first = sharpest(track, {});
    const auto second = first ? sharpest(track, first) : std::nullopt;
    if (!second)
        return core::fail(
            ErrorCode::fit_not_evaluable,
            "edges: the contour has no two places that turn by 120 degrees within a quarter of its length");
    EdgeRegion a = region_of(track, *first), b = region_of(track, *second);
    if (holds(a, b.begin) || holds(a, b.end) || holds(b, a.begin))
        return core::fail(ErrorCode::fit_not_evaluable, "edges: the two edges overlap");
    BladeEdges edges;
    const Vec2 nose_a = contour[a.nose].position, nose_b = contour[b.nose].position;
    const bool a_leads = first_leads(nose_a, nose_b, a.scale_mm, b.scale_mm, le_hint, te_hint);
    edges.le = a_leads ? a : b;
    edges.te = a_leads ? b : a;
    edges.suction_after_le = bulges_after(contour, contour[edges.le.nose].position, contour[edges.te.nose].position);
    return edges;
}

std::vector<Zone> zones_of(const BladeEdges& edges, std::size_t count) {
    std::vector<Zone> zones(count);
    const Zone after_le = edges.suction_after_le ? Zone::suction : Zone::pressure;
    const Zone after_te = edges.suction_after_le ? Zone::pressure : Zone::suction;
    Zone side = after_le;
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = cyclic(edges.le.nose + k, count);
        if (i == edges.te.nose) side = after_te;
        zones[i] = holds(edges.le, i) ? Zone::le : holds(edges.te, i) ? Zone::te : side;
    }
    return zones;
}

}  // namespace cmm::fitting
