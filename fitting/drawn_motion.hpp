// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "fitting/best_fit.hpp"
#include "fitting/measured_section.hpp"

namespace cmm::fitting {

/// How a min-max motion answers to the contours that it was found from. It rests on four places, and on others as soon
/// as noise makes their distances the largest: what these four do says neither how far it may be off nor, where two lie
/// side by side, anything near it.
struct DrawnMotion {
    std::vector<MotionSlopes> slopes;  ///< by member, on average over what the contours may be
    Eigen::Matrix3d covariance;        ///< mm and rad, about the motion found, from the noise of the points alone
};

/// The parametric bootstrap (Efron and Tibshirani 1993, section 6.5): the motion for 100 draws of the contours' errors
/// from their covariance, each the exact min-max step (chebyshev.hpp) by the distances that come near the largest. The
/// mean of the draws' slopes is the covariance of motion and errors divided by that of the errors (Stein 1981); those
/// of two places side by side, by which the motion would err three times as much as it does, are left out of it. The
/// same numbers each time. Nothing where the fit is no min-max one or its distances do not determine it.
std::optional<DrawnMotion> draw_motions(const BestFit& fit, std::span<const MeasuredSection* const> sections);

}  // namespace cmm::fitting
