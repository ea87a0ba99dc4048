// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <span>

#include "core/error.hpp"
#include "fitting/statistics.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// Of a shorter arc no radius is stated.
inline constexpr double shortest_arc_rad = std::numbers::pi / 3.0;

/// A circle through points and how well it is known.
struct Circle {
    Vec2 centre = Vec2::Zero();
    double radius = 0.0;
    double rms = 0.0;         ///< of the orthogonal distances, n - 3 degrees of freedom
    double radius_u95 = 0.0;  ///< half the 95 % interval: Student's t times the standard uncertainty
    double arc_angle = 0.0;   ///< that the points span, radians
    Noise noise;              ///< that the uncertainties are computed from
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of centre x, centre y, radius; mm^2
};

/// The algebraic circle of Kasa 1976 (seed 000, eq 1-5; sign of eq 4 corrected): a start value only, biased small on
/// short noisy arcs (A14). Errors: fit_not_evaluable (fewer than 3 points, collinear).
core::Result<Circle> fit_circle_kasa(std::span<const Vec2> points);

/// The circle of least squared orthogonal distances (Gauss-Newton with step halving from Kasa's circle), any order of
/// points. `known` is what is known of the noise beforehand. Errors: fit_not_evaluable (fewer than 5 points, collinear,
/// no convergence, arc below 60 degrees: the radius would be noise, A14).
core::Result<Circle> fit_circle(std::span<const Vec2> points, const Noise& known = {});

}  // namespace cmm::fitting
