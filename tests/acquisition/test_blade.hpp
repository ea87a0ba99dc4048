// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "acquisition/part_file.hpp"

/// Parts and measures that several tests of the inputs share.
namespace cmm::acquisition {

/// A part that nobody has drawn, in a box.
inline const std::string none_part = R"([part]
name = "u"
[nominal]
kind = "none"
[scan]
heights_mm = [1, 2.5]
box_mm = [-10, -5, 10, 5]
)";

inline const std::string blade_table = R"([nominal.blade]
chord_root_mm = 30
chord_tip_mm = 25
thickness_root_mm = 3
thickness_tip_mm = 2.5
camber_deg = 30
stagger_root_deg = 20
stagger_tip_deg = 28
le_radius_mm = 0.5
te_radius_mm = 0.3
lean_x_deg = 2
lean_y_deg = -3
z_root_mm = 0
z_tip_mm = 60
)";

/// The blade of that table.
inline ParametricBlade test_blade() {
    constexpr double degree = std::numbers::pi / 180.0;
    return {30.0, 25.0, 3.0,          2.5,           30.0 * degree, 20.0 * degree, 28.0 * degree,
            0.5,  0.3,  2.0 * degree, -3.0 * degree, 0.0,           60.0};
}

inline double distance_to_segment(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    const Eigen::Vector2d d = b - a;
    const double t = d.squaredNorm() > 0.0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
    return (p - a - t * d).norm();
}

inline double distance_to_polygon(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& polygon) {
    double best = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        best = std::min(best, distance_to_segment(p, polygon[i], polygon[(i + 1) % polygon.size()]));
    }
    return best;
}

/// The largest distance of a point of `a` from `b`.
inline double largest_distance(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
    double worst = 0.0;
    for (const auto& p : a)
        worst = std::max(worst, distance_to_polygon(p, b));
    return worst;
}

/// Real parts lie beside the repository where somebody has put them.
inline std::string real_data(const std::string& name) {
    return (std::filesystem::path("../shared/data") / name).string();
}

}  // namespace cmm::acquisition
