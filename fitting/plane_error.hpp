// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fitting/sensitivity.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

struct ContourPoint;

/// How well the plane of a section is known: the covariance of its height (mm) at a place of the section and of its
/// tilts about x and y (rad), standard.
struct PlaneUncertainty {
    Vec2 about_mm = Vec2::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// What that makes of a contour: where the wall leans by a, a plane that lies too low by h cuts tan(a) h farther out,
/// at all places by the same three errors. Value type; by default there is none.
class PlaneError {
  public:
    PlaneError() = default;
    /// `leans_rad`: of the surface at each point, positive where its outward normal points upwards.
    PlaneError(std::span<const ContourPoint> contour, std::span<const double> leans_rad, const PlaneUncertainty& plane);
    /// In the square of the number's unit.
    double variance(const Sensitivity& number) const;

  private:
    std::vector<Eigen::Vector3d> by_point_;  // outwards, by height and tilts
    Eigen::Matrix3d covariance_ = Eigen::Matrix3d::Zero();
};

}  // namespace cmm::fitting
