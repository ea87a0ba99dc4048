// SPDX-License-Identifier: Apache-2.0
#include "fitting/kinks.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace cmm::fitting {
namespace {

/// Distance of p to the least-squares parabola through the side's points, in the frame of their chord.
double off_side(std::span<const Vec2> side, const Vec2& p) {
    const Vec2 origin = side.front(), along = (side.front() - side.back()).normalized();
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
    const auto row_at = [&](const Vec2& q) {
        const double x = (q - origin).dot(along);
        return Eigen::Vector3d(1.0, x, x * x);
    };
    for (const Vec2& q : side) {
        const Eigen::Vector3d row = row_at(q);
        normal.noalias() += row * row.transpose();
        rhs += cross(along, q - origin) * row;
    }
    const Eigen::Vector3d parabola = normal.ldlt().solve(rhs), row = row_at(p);
    const double slope = parabola[1] + 2.0 * parabola[2] * row[1];
    return std::abs(cross(along, p - origin) - parabola.dot(row)) / std::sqrt(1.0 + slope * slope);
}

}  // namespace

bool continues_a_side(std::span<const Vec2> cluster, std::span<const Vec2> before, std::span<const Vec2> after,
                      double tolerance_mm) {
    if (before.size() < 3 || after.size() < 3) return false;
    return std::all_of(cluster.begin(), cluster.end(), [&](const Vec2& p) {
        return std::min(off_side(before, p), off_side(after, p)) <= tolerance_mm;
    });
}

}  // namespace cmm::fitting
