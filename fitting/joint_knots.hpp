// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "fitting/curvature_joints.hpp"
#include "fitting/smoothing_system.hpp"

namespace cmm::fitting {

/// The three close knots by which a smoothing spline has a joint: the outer two let the curvature jump, and its slope;
/// the middle one lets the tangent turn, as a joint elsewhere would have it (docs/theory.md, section 3).
inline constexpr std::size_t knots_of_joint = 3;

/// A joint's place is known to some hundredths of a millimetre: what rounding does to it must not move the curve.
double on_grid(double t);

/// Whether joints at two places leave each other their knots; where the curve begins and ends is before and behind all
/// (infinite).
bool have_room(double t, double next_t, std::span<const double> breaks);

/// The breaks with those of joints at these places; `knots` are written.
std::vector<double> with_joint_knots(std::span<const double> breaks, std::span<const double> places,
                                     std::vector<KnotCluster>& knots);
/// The breaks but for those of the joints.
std::vector<double> without_joint_knots(const std::vector<double>& breaks, std::span<const KnotCluster> joints);

/// Lets the curvature jump there. The joint, by `step`, is known to lie `ahead_mm` of the knots, with this standard
/// deviation.
void free_joint(SmoothingSystem& system, const KnotCluster& knots, double step, double sigma_mm, double ahead_mm = 0.0);

/// What the curve says of a joint.
struct SeenJoint {
    double step = 0.0;   ///< of the curvature
    double shift = 0.0;  ///< from the knots to where the tangents of both sides agree
};
SeenJoint seen_at(const PiecewiseCubic& curve, double t, double apart);

/// How far the curve has a joint, by `step`, from where it is known to lie.
double off_expected_mm(const SmoothingSystem& system, const KnotCluster& knots, double step);

/// Writes what the points say of a joint's place without what was known of it. Of the turn at its middle knot they
/// determine the share g: what the curve has of it is g of theirs and 1 - g of what was known, and (1 - g)/g of the
/// variance before is the variance of theirs.
void tell_place(const SmoothingSystem& system, const KnotCluster& knots, double step, CurvatureStep& joint,
                double ahead_mm = 0.0);

}  // namespace cmm::fitting
