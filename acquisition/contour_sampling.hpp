// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "acquisition/nominal.hpp"

namespace cmm::acquisition {

/// A point of a plane cut and the direction in which the surface goes on from it out of the plane.
struct CutPoint {
    Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();
    Eigen::Vector3d spanwise = Eigen::Vector3d::UnitZ();
};

/// Parameters that sample a closed curve densely: at least 1200 a lap and a chord error below 0.2 um. `coarse` are
/// parameters in running order, fine enough to show the curve's shape; the lap closes from the last to the first plus
/// `period`.
std::vector<double> dense_parameters(const std::function<Eigen::Vector2d(double)>& position,
                                     const std::vector<double>& coarse, double period);

double signed_area(const std::vector<Eigen::Vector2d>& polygon) noexcept;
/// The contour counter-clockwise with its lean (angle between the surface normal and the section plane, largest over
/// all points; also by point, with its sign).
NominalContour contour_from(double z_mm, const std::vector<CutPoint>& cut);

}  // namespace cmm::acquisition
