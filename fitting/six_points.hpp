// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"

/// The frame of a part by six datum points (RPS, 3-2-1 or any other six that leave no motion free), each of which fixes
/// the part along one direction by one touch, or by the middle of two. Millimetres and radians. "Part" is the frame of
/// the nominal, "machine" that of the touches.
namespace cmm::fitting {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// A place of the nominal and the direction in which it counts: unit, out of the material.
struct DatumTouch {
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
};

/// One touch; or the middle of two on opposite sides: what both lie too far out by, the part being too thick there,
/// leaves it where it is.
struct DatumPoint {
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();
    std::optional<DatumTouch> opposite = {};

    Eigen::Vector3d middle_mm() const { return opposite ? 0.5 * (place_mm + opposite->place_mm) : place_mm; }
};
inline constexpr std::size_t datum_points = 6;
using SixPoints = std::array<DatumPoint, datum_points>;
/// In the order in which they are made: of each datum its touch, then the opposite one.
std::vector<DatumTouch> touches_of(const SixPoints& points);
using TouchCentres = std::vector<Eigen::Vector3d>;  ///< of the ball, one a touch
/// The touches of a middle face away from each other by this angle at least; nearer to a right angle they would fix it
/// along no direction.
inline constexpr double smallest_opposition_rad = 2.0943951;  // 120 degrees

/// A motion that six points hardly feel: a shift where `turn` is zero, else a turn about an axis, with a shift along
/// it.
struct FreeMotion {
    Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< unit where there is no turn
    Eigen::Vector3d axis = Eigen::Vector3d::Zero();   ///< unit; zero: a shift alone
    Eigen::Vector3d through_mm = Eigen::Vector3d::Zero();
    double pitch_mm = 0.0;  ///< shift along the axis of a turn by one radian
};

/// How well six points hold a part. The 6 x 6 system has the rows (n_i, (p_i - c) x n_i / L) for the shift and for the
/// turn times L, of a middle half the difference of those of its two touches, with c the mean of the places (of a
/// middle that between its two) and L their root mean square distance from it: all lengths are in units of the set's
/// own size, so that the condition number (largest over smallest singular value) is one of the arrangement alone,
/// whatever unit, origin or axes it is written in.
struct SixPointHold {
    double condition = 1.0;                               ///< infinite: a motion is entirely free
    double length_mm = 0.0;                               ///< L
    Eigen::Vector3d middle_mm = Eigen::Vector3d::Zero();  ///< c
    std::vector<FreeMotion> weak;                         ///< felt less than 1/largest_condition of the best felt one
};
/// Default of the largest condition number: a micrometre of the touches is two tenths of a millimetre of the motion
/// that is held worst.
inline constexpr double largest_condition_default = 200.0;
SixPointHold hold_of(const SixPoints& points, double largest_condition = largest_condition_default);
/// How the part's frame follows its touches, in their order: shift and turn about the mean of the places, by the
/// distances (outwards along the directions) by which they are off. Only of points that hold the part.
Eigen::Matrix<double, 6, Eigen::Dynamic> motion_by_touches(const SixPoints& points);
/// "the six points do not hold the part: condition 1e+16, free is a turn about the axis (0.00, 0.00, 1.00) through ..."
std::string weak_words(const SixPointHold& hold);
/// Errors: config_invalid, in the words above, when the condition number is larger than that; also of a middle whose
/// touches do not face away from each other.
core::Status require_hold(const SixPoints& points, double largest_condition = largest_condition_default);

/// The rigid motion that takes the part's places to the machine's: n_i . (T^-1 c_i - p_i) = r for the ball centres c_i
/// of single touches, the same of both touches of a middle, by Newton's method on the whole rotation, from `start` on.
/// Errors: fit_not_evaluable (no convergence: the centres contradict any position near the start).
core::Result<Eigen::Isometry3d> solve_six_points(const SixPoints& points, const TouchCentres& centres_mm,
                                                 double ball_radius_mm, const Eigen::Isometry3d& start);

/// How far the balls lie off the places along their directions, mm, in the frame of `machine_from_part`; of a middle
/// half of what the first touch lies farther off than the second.
std::array<double, datum_points> six_residuals(const SixPoints& points, const TouchCentres& centres_mm,
                                               double ball_radius_mm, const Eigen::Isometry3d& machine_from_part);
/// Of middles: what the part is too thick by between their two touches, mm.
std::array<std::optional<double>, datum_points> six_excesses(const SixPoints& points, const TouchCentres& centres_mm,
                                                             double ball_radius_mm,
                                                             const Eigen::Isometry3d& machine_from_part);

struct SixPointOptions {
    double residual_mm = 0.005;  ///< a round has converged when no touch lies farther off where it was expected ...
    double moved_mm = 0.05;      ///< ... and no place moves farther by it
    int most_rounds = 10;
    double touch_standard_mm = 0.001;  ///< standard uncertainty of one touch, independent of the others
};

/// What six points found. The covariance is that of a small motion of the part, shift (mm) at `about_mm` and turn
/// (rad), both along the part's axes: a measured point p of the part is wrong by -(shift + turn x (p - about_mm)).
struct SixPointFrame {
    Eigen::Isometry3d machine_from_part = Eigen::Isometry3d::Identity();
    Matrix6 covariance = Matrix6::Zero();
    Eigen::Vector3d about_mm = Eigen::Vector3d::Zero();
    std::array<double, datum_points> residual_mm{};  ///< of the last touches, against the frame of the round before
    std::array<std::optional<double>, datum_points> excess_mm{};  ///< of middles: too thick by this, in the frame found
    double moved_mm = 0.0;                                        ///< farthest that a place moved by the last round
    double condition = 1.0;
    double length_mm = 0.0;  ///< that the condition number's lengths are counted in
    double touch_standard_mm = 0.0;
    int rounds = 0;
    std::optional<SixPoints> points;   ///< that were touched, in the part's frame; unknown: of an older run
    Matrix6 shared = Matrix6::Zero();  ///< covariance by what the touches have in common with all other points

    /// How far the part's point `about_mm` lies from the same numbers on the machine, and the turn about it: axis times
    /// angle.
    Eigen::Vector3d shift_mm() const { return machine_from_part * about_mm - about_mm; }
    Eigen::Vector3d turn_rad() const;
    /// Standard uncertainties, all together: three of the shift (mm), three of the turn (rad).
    std::array<double, 6> standard() const;
    double largest_residual_mm() const;
};

/// The rounds of an iterative alignment, driven from outside: touch every place where `frame()` puts it, hand in the
/// ball centres, go on until `take` says true. It iterates because a touch beside its place feels another spot of the
/// part: by e beside it a surface of curvature k is felt wrong by k e^2/2, so that the error of a round goes with the
/// square of the one before. A value, no I/O.
class SixPointRounds {
  public:
    SixPointRounds(const SixPoints& points, double ball_radius_mm, const SixPointOptions& options);
    /// True: converged. Errors: fit_not_evaluable (the centres fit no position, or the rounds are used up: with the
    /// residual and the motion that are left, and at which point).
    core::Result<bool> take(const TouchCentres& centres_mm);
    /// As it is now; identity before the first round.
    const SixPointFrame& frame() const { return frame_; }

  private:
    core::Error not_converged() const;
    Eigen::Matrix<double, 6, 1> touch_variances() const;
    SixPoints points_;
    double ball_radius_mm_;
    SixPointOptions options_;
    SixPointFrame frame_;
};

}  // namespace cmm::fitting
