// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/measured_section.hpp"
#include "fitting/plane_motion.hpp"

namespace cmm::fitting {

enum class FitObjective : std::uint8_t {
    least_squares,   ///< of the distances from the middle of the zone, each point with the length it stands for
    min_max,         ///< the largest distance from the middle of the zone is smallest
    into_tolerance,  ///< the same as a share of the zone's half width: what can lie in its zone does
};
std::string_view to_string(FitObjective objective) noexcept;

/// Where the deviations of a zone may lie, mm, outwards positive.
struct ToleranceZone {
    double middle_mm = 0.0;
    double half_mm = 1.0;  ///< half of its width; of objective into_tolerance alone
};

struct BestFitOptions {
    FitObjective objective = FitObjective::least_squares;
    bool translate_x = true, translate_y = true, rotate = true;  ///< false: held at zero
    std::array<bool, 4> zones{true, true, true, true};           ///< that take part, by Zone
    std::array<ToleranceZone, 4> tolerance{};                    ///< by Zone
};

/// What a fit lays onto each other. `use`: not of a point means that it takes no part (empty: all). All must outlive
/// the fit; the nominal of each section is in the frame of the part.
struct FitMember {
    const ContourGeometry* contour = nullptr;
    const ClosedCurve* nominal = nullptr;
    std::span<const char> use;
};

/// A distance that a min-max motion makes small, from the middle of its zone and in the unit of the objective, at that
/// motion.
struct FitDistance {
    std::size_t member, point;
    double off;
    Eigen::Vector3d slopes;  ///< by which it shrinks with shift x, shift y and turn; 0 by what may not move
    double unit_mm;
};

/// How the numbers of a motion (shift x, shift y, turn) answer to a contour.
using MotionSlopes = std::array<Sensitivity, 3>;

/// How a measured section, or several as one rigid body, lie to their nominals: the nominal, turned by
/// `motion.turn_rad` about `motion.about_mm` (its centre of area; of several: the mean of theirs) and then moved by
/// `motion.shift_mm`, is nearest to the contour. `motion.undo` carries a point of the contour into the nominal's frame.
struct BestFit {
    PlaneMotion motion;
    double rms_mm = 0.0;      ///< of the distances from the middles that are left, by arc length
    double largest_mm = 0.0;  ///< of them
    int rounds = 0;
    double condition = 1.0;              ///< of the free parameters, lengths in units of the section's size
    Measure dx, dy, twist;               ///< with what they depend on; of several sections without
    std::vector<MotionSlopes> slopes;    ///< by member
    std::vector<FitDistance> distances;  ///< of the two min-max objectives alone
};

/// Closest points and a step in turn until it moves by less than 0.1 nm: for least squares that of Gauss and Newton
/// along the normals of the nominal, each point weighing the length of contour that it stands for, so that a densely
/// measured edge does not outweigh a side (Chen and Medioni 1992); for the two others the exact linear min-max step
/// (chebyshev.hpp), shortened until it gets better. Points whose nearest place on the nominal faces the other way take
/// no part; where it stands still all nearest places are sought anew, until that moves nothing. The slopes of
/// a min-max motion are those of the points that it rests on; what its uncertainty is, datum.hpp says. Errors:
/// fit_not_evaluable (fewer than 12 points, a motion that they do not determine, no convergence), usage (nothing may
/// move).
core::Result<BestFit> fit_to_nominal(const ContourGeometry& contour, const ClosedCurve& nominal,
                                     const BestFitOptions& options = {}, std::span<const char> use = {});
/// All sections by one motion; a section weighs its length.
core::Result<BestFit> fit_to_nominals(std::span<const FitMember> members, const BestFitOptions& options = {});

}  // namespace cmm::fitting
