// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "fitting/compensation.hpp"

namespace cmm::fitting::families {

/// Largest distance of the points of `to` from the closed polygon through those of `from`, both in one plane. Every
/// edge is looked at.
inline double contour_change_mm(const ContactContour& from, const ContactContour& to) {
    double largest = 0.0;
    for (const auto& point : to.points) {
        const Eigen::Vector2d p = point.position_mm.head<2>();
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < from.points.size(); ++i) {
            const Eigen::Vector2d a = from.points[i].position_mm.head<2>();
            const Eigen::Vector2d along = from.points[(i + 1) % from.points.size()].position_mm.head<2>() - a;
            const double t = std::clamp(along.dot(p - a) / along.squaredNorm(), 0.0, 1.0);
            nearest = std::min(nearest, (p - a - t * along).squaredNorm());
        }
        largest = std::max(largest, std::sqrt(nearest));
    }
    return largest;
}

}  // namespace cmm::fitting::families
