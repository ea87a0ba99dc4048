// SPDX-License-Identifier: Apache-2.0
#include "fitting/thickness.hpp"

#include <algorithm>
#include <limits>

namespace cmm::fitting {
namespace {

constexpr std::size_t coarse_points = 160;

/// Radius of the largest circle that touches the contour at `at` from inside, against every `stride`-th point.
double inscribed_radius(std::span<const OffsetPoint> contour, std::size_t at, std::size_t stride, double nearest) {
    const OffsetPoint& p = contour[at];
    double radius = std::numeric_limits<double>::infinity();
    for (std::size_t j = at % stride; j < contour.size(); j += stride) {
        const Vec2 d = contour[j].position - p.position;
        const double depth = -d.dot(p.normal);
        // Very near neighbours only give the local radius of curvature with all its noise.
        if (d.squaredNorm() < nearest * nearest || !(depth > 0.0)) continue;
        radius = std::min(radius, d.squaredNorm() / (2.0 * depth));
    }
    return radius;
}

}  // namespace

double largest_inscribed_diameter(std::span<const OffsetPoint> contour) {
    const std::size_t n = contour.size(), stride = std::max<std::size_t>(1, n / coarse_points);
    Vec2 low = contour[0].position, high = low;
    for (const OffsetPoint& p : contour) {
        low = low.cwiseMin(p.position);
        high = high.cwiseMax(p.position);
    }
    const double nearest = 2e-3 * (high - low).norm();
    double best = 0.0;
    std::size_t where = 0;
    for (std::size_t i = 0; i < n; i += stride) {
        const double radius = inscribed_radius(contour, i, stride, nearest);
        if (radius < std::numeric_limits<double>::infinity() && radius > best) {
            best = radius;
            where = i;
        }
    }
    // The maximum is flat: a few fine points around it settle it.
    best = 0.0;
    for (std::size_t k = 0; k <= 16; ++k) {
        const std::size_t i = (where + n + k * stride / 8 - stride) % n;
        const double radius = inscribed_radius(contour, i, 1, nearest);
        if (radius < std::numeric_limits<double>::infinity()) best = std::max(best, radius);
    }
    return 2.0 * best;
}

}  // namespace cmm::fitting
