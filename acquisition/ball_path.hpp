// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/error.hpp"
#include "fitting/nominal.hpp"

namespace cmm::acquisition {

/// A point of the closed curve on which the ball centre runs.
struct BallPoint {
    Eigen::Vector2d centre_mm = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::UnitX();  ///< unit, out of the material
    double contour_mm = 0.0;                            ///< arc length of the contact on the contour
    double step_mm = 0.0;                               ///< sampled paths: the local spacing
};

/// A concave place that the ball cannot reach: it bridges it.
struct UnreachedPlace {
    Eigen::Vector2d position_mm = Eigen::Vector2d::Zero();
    double depth_mm = 0.0;  ///< by so much the ball would enter the material
};

struct BallPath {
    std::vector<BallPoint> points;  ///< closed, counter-clockwise, dense
    std::vector<UnreachedPlace> unreached;
    double dense_step_mm = 0.0;  ///< of the contacts on the contour
};

/// The outward parallel curve of a contour at the ball radius. Loops, where the ball does not fit, are cut off at their
/// crossing and reported (A24).
BallPath ball_path(const fitting::ClosedCurve& contour, double ball_radius_mm);

struct SamplingOptions {
    double pitch_mm = 0.4;         ///< on the sides
    double edge_density = 4.0;     ///< so many times denser at LE and TE
    double chord_error_mm = 1e-3;  ///< e of the step sqrt(8 e / kappa) between the two
    std::size_t overlap = 3;       ///< points past the start, so that the section closes
};

/// Points to measure along the path: from the middle of the suction side once round counter-clockwise and over the
/// start. The step follows the curvature of the ball-centre curve and changes smoothly.
std::vector<BallPoint> sample_ball_path(const BallPath& path, const fitting::NominalSection& section,
                                        double ball_radius_mm, const SamplingOptions& options);

}  // namespace cmm::acquisition
