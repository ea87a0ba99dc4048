// SPDX-License-Identifier: Apache-2.0
#include "fitting/hollows.hpp"

#include <algorithm>

#include "fitting/offset.hpp"

namespace cmm::fitting {
namespace {

constexpr double same_side_cosine = 0.5;

/// Over the pieces of the stretch, each at a few places: pieces are short where the curve turns.
double depth_of(const PiecewiseCubic& curve, const Hollow& hollow) {
    constexpr int places = 8;
    double from = hollow.from;
    const std::size_t first = curve.span_of(from);
    double deepest = 0.0;
    for (std::size_t n = 0, k = first; n <= curve.spans(); ++n, k = (k + 1) % curve.spans()) {
        const double low = curve.breaks()[k], width = curve.breaks()[k + 1] - low;
        bool inside = false;
        for (int i = 0; i <= places; ++i) {
            const double t = low + width * i / places;
            if (!hollow.holds(t)) continue;
            inside = true;
            deepest = std::max(deepest, (curve.jet_in(k, t).position - hollow.centre).norm() - hollow.radius_mm);
        }
        if (!inside && n > 0) break;
    }
    return deepest;
}

}  // namespace

bool Hollow::bridges(const Vec2& point, const Vec2& normal) const {
    const Vec2 to_begin = begin - centre, to_end = end - centre, to_point = point - centre;
    const double distance = to_point.norm();
    if (distance > 2.0 * radius_mm || -normal.dot(to_point) < same_side_cosine * distance) return false;
    // The ball's part between the contacts is less than half of it and turns clockwise from the first to the second.
    return cross(to_begin, to_point) <= 0.0 && cross(to_point, to_end) <= 0.0;
}

std::vector<Hollow> find_hollows(const PiecewiseCubic& curve, double ball_radius_mm, double least_depth_mm) {
    std::vector<Hollow> hollows;
    if (!(ball_radius_mm > 0.0)) return hollows;
    for (const OffsetCorner& corner : offset_curve(curve, ball_radius_mm, 1).corners) {
        Hollow hollow;
        hollow.centre = corner.position;
        hollow.radius_mm = ball_radius_mm;
        hollow.begin = curve.jet(corner.from).position;
        hollow.end = curve.jet(corner.to).position;
        hollow.from = corner.from;
        hollow.to = corner.to;
        hollow.depth_mm = depth_of(curve, hollow);
        if (hollow.depth_mm >= least_depth_mm) hollows.push_back(hollow);
    }
    std::sort(hollows.begin(), hollows.end(), [](const Hollow& a, const Hollow& b) { return a.from < b.from; });
    return hollows;
}

}  // namespace cmm::fitting
