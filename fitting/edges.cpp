// SPDX-License-Identifier: Apache-2.0
#include "fitting/edges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/section.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double edge_turn_rad = 2.0 * std::numbers::pi / 3.0;
constexpr double longest_share = 0.25;        // of the perimeter; a circle turns 120 degrees in a third of it
constexpr double apart_share = 0.2;           // the two edges' middles are at least this share of the perimeter apart
constexpr double transition_curvature = 0.4;  // of the edge's mean curvature

/// Arc length and unwrapped direction of the normal, three laps long so that no index wraps.
struct Track {
    std::vector<double> s, angle;
    std::size_t n = 0;
    double perimeter = 0.0;

    explicit Track(std::span<const OffsetPoint> contour) : n(contour.size()) {
        s.assign(3 * n + 1, 0.0);
        angle.assign(3 * n + 1, 0.0);
        for (std::size_t i = 1; i < s.size(); ++i) {
            const OffsetPoint& from = contour[(i - 1) % n];
            const OffsetPoint& to = contour[i % n];
            s[i] = s[i - 1] + (to.position - from.position).norm();
            angle[i] = angle[i - 1] + turn_angle(from.normal, to.normal);
        }
        perimeter = s[n];
    }

    std::size_t at(double where) const {
        const auto found = std::lower_bound(s.begin(), s.end(), where);
        return std::min(static_cast<std::size_t>(found - s.begin()), s.size() - 1);
    }
};

struct Window {
    std::size_t begin = 0, end = 0;  // on the middle lap of the track
    double length = 0.0;
};

/// The shortest arc that turns by 120 degrees, at least `apart` from `other`. The first, coarse pass only finds a
/// length that bounds the second: texture makes the direction go back and forth, so two running ends would not do.
std::optional<Window> sharpest(const Track& track, const std::optional<Window>& other) {
    std::optional<Window> best;
    double limit = longest_share * track.perimeter;
    const auto try_from = [&](std::size_t i) {
        std::size_t j = i + 1;
        while (j + 1 < track.s.size() && track.s[j] - track.s[i] < limit &&
               track.angle[j] - track.angle[i] < edge_turn_rad)
            ++j;
        const double length = track.s[j] - track.s[i];
        if (length >= limit || track.angle[j] - track.angle[i] < edge_turn_rad) return;
        if (other) {
            const double middle = 0.5 * (track.s[i] + track.s[j]);
            const double theirs = 0.5 * (track.s[other->begin] + track.s[other->end]);
            if (std::abs(std::remainder(middle - theirs, track.perimeter)) < apart_share * track.perimeter) return;
        }
        limit = length;
        best = Window{i, j, length};
    };
    for (const std::size_t stride : {std::size_t{16}, std::size_t{1}})
        for (std::size_t i = track.n; i < 2 * track.n; i += stride)
            try_from(i);
    return best;
}

EdgeRegion region_of(const Track& track, const Window& window) {
    EdgeRegion region;
    region.scale_mm = std::max(window.length, 1e-6) / edge_turn_rad;
    const double lag = 0.35 * region.scale_mm;
    const double least = transition_curvature / region.scale_mm * lag;
    const double farthest = 4.0 * region.scale_mm;
    const std::size_t middle = track.at(0.5 * (track.s[window.begin] + track.s[window.end]));

    std::size_t end = middle;
    while (end + 1 < track.s.size() && track.s[end] - track.s[middle] < farthest) {
        const std::size_t ahead = track.at(track.s[end] + lag);
        if (track.angle[ahead] - track.angle[end] < least && end >= window.end) break;
        ++end;
    }
    std::size_t begin = middle;
    while (begin > 0 && track.s[middle] - track.s[begin] < farthest) {
        const std::size_t behind = track.at(track.s[begin] - lag);
        if (track.angle[begin] - track.angle[behind] < least && begin <= window.begin) break;
        --begin;
    }
    // The sides are taken a little away from the edge, where they hardly turn: their normals are then stable.
    const double away = 2.0 * region.scale_mm;
    const double before = track.angle[track.at(track.s[begin] - away)];
    const double after = track.angle[track.at(track.s[end] + away)];
    const double halfway = 0.5 * (before + after);
    std::size_t nose = begin;
    while (nose < end && track.angle[nose] < halfway)
        ++nose;

    region.begin = begin % track.n;
    region.end = end % track.n;
    region.middle = middle % track.n;
    region.nose = nose % track.n;
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
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const Vec2 a = contour[i].position - le, b = contour[(i + 1) % contour.size()].position - le;
        twice += cross(a, b);
        moment += cross(a, b) * (a + b);
    }
    // Counter-clockwise from the LE runs the side on the right of the chord direction LE -> TE.
    return cross(te - le, Vec2(moment / (3.0 * twice))) <= 0.0;
}

}  // namespace

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
        const std::size_t i = (edges.le.nose + k) % count;
        if (i == edges.te.nose) side = after_te;
        zones[i] = holds(edges.le, i) ? Zone::le : holds(edges.te, i) ? Zone::te : side;
    }
    return zones;
}

}  // namespace cmm::fitting
