// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "fitting/best_fit.hpp"
#include "fitting/measured_section.hpp"
#include "fitting/plane_motion.hpp"

namespace cmm::fitting {

/// A motion from the nominal's frame to the measured one, found from measured contours, as one of these contours sees
/// it: by what of its errors comes from this contour itself and by what from elsewhere, so that numbers of the aligned
/// contour do not count its own errors twice. Covariances of shift x, shift y (mm) and turn (rad), standard.
struct Datum {
    PlaneMotion motion;
    MotionSlopes slopes;                                    ///< by this contour's points
    Eigen::Matrix3d from_others = Eigen::Matrix3d::Zero();  ///< not by these slopes
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();   ///< of all together, each independent of the others
    Eigen::Matrix3d places = Eigen::Matrix3d::Zero();       ///< part of it: by what the machine does place by place
    /// By what all sections have in common (error_fields.hpp): of the other contours, and of all.
    MotionLoads loads_of_others = MotionLoads::Zero(), loads = MotionLoads::Zero();

    /// `measure` was taken of the contour after the motion was undone: what it depends on, the motion's errors
    /// included. How a number answers to a motion follows from how it answers to the points' displacements.
    Measure of_aligned(Measure measure, const ContourGeometry& aligned) const;
};

/// How the displacement along the normal at a point of the measured contour answers to shift x, shift y and turn.
Eigen::Vector3d answer_to_motion(const PlaneMotion& motion, const Vec2& position_mm, const Vec2& normal);

/// The standard uncertainty of a deviation at a measured point, outward normal `normal`, by the motion alone.
double normal_uncertainty(const PlaneMotion& motion, const Eigen::Matrix3d& covariance, const Vec2& position_mm,
                          const Vec2& normal);

/// Writes into each point of a measured contour what machine, probe and temperature add to its place along the normal,
/// after the alignment (nullptr: as measured).
void set_place_errors(std::vector<ContourPoint>& contour, const ContourNoise& noise, const Datum* datum);

/// One datum for each section of a fit, in its order: noise of different sections is independent, of each the bounds
/// count as if they were standard uncertainties. Of a min-max motion by draws (drawn_motion.hpp).
std::vector<Datum> datums_of(const BestFit& fit, std::span<const MeasuredSection* const> sections);

/// A fit as it lies in the frame from which `motion` leads to it: contour, centres and edges; the centres of the balls
/// stay as measured.
SectionFit undone(SectionFit fit, const PlaneMotion& motion);

}  // namespace cmm::fitting
