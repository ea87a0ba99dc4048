// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "core/error.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A circle through points and how well it is known.
struct Circle {
    Vec2 centre = Vec2::Zero();
    double radius = 0.0;
    double rms = 0.0;         ///< of the orthogonal distances, n - 3 degrees of freedom
    double radius_u95 = 0.0;  ///< k = 2, from max(rms, the given sigma)
    double arc_angle = 0.0;   ///< that the points span, radians
};

/// The algebraic circle of Kasa 1976 (seed 000, eq 1-5; sign of eq 4 corrected): a start value only, biased small on
/// short noisy arcs (A14). Errors: fit_not_evaluable (fewer than 3 points, collinear).
core::Result<Circle> fit_circle_kasa(std::span<const Vec2> points);

/// The circle of least squared orthogonal distances (Gauss-Newton with step halving from Kasa's circle).
/// `sigma_mm` is what is known of the noise beforehand (0: nothing). Errors: fit_not_evaluable (fewer than 5 points,
/// collinear, no convergence, arc below 60 degrees: the radius would be noise, A14).
core::Result<Circle> fit_circle(std::span<const Vec2> points, double sigma_mm = 0.0);

}  // namespace cmm::fitting
