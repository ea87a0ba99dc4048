// SPDX-License-Identifier: Apache-2.0
#include "fitting/plane_error.hpp"

#include <algorithm>
#include <cmath>

#include "fitting/section.hpp"

namespace cmm::fitting {
namespace {

constexpr double steepest_rad = 1.4;  // about 80 degrees; there is no section of a wall that is flatter

}  // namespace

PlaneError::PlaneError(std::span<const ContourPoint> contour, std::span<const double> leans_rad,
                       const PlaneUncertainty& plane)
    : covariance_(plane.covariance) {
    by_point_.reserve(contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const Vec2 arm = contour[i].position_mm - plane.about_mm;
        by_point_.emplace_back(std::tan(std::clamp(leans_rad[i], -steepest_rad, steepest_rad)) *
                               Eigen::Vector3d(1.0, arm.y(), -arm.x()));
    }
}

double PlaneError::variance(const Sensitivity& number) const {
    if (by_point_.empty()) return 0.0;
    Eigen::Vector3d answer = Eigen::Vector3d::Zero();
    for (const auto& [point, weight] : number.parts())
        answer += weight * by_point_[point];
    return std::max(0.0, answer.dot(covariance_ * answer));
}

}  // namespace cmm::fitting
