// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "fitting/six_points.hpp"
#include "fitting/vec2.hpp"

/// What machine, probe and temperature do alike to many points, and no scatter tells (docs/theory.md, section 16).
/// Millimetres, radians; frame of the measured points.
namespace cmm::fitting {

/// Where such an error comes from.
enum class ErrorSource : std::uint8_t { ball, probing, length, temperature };
inline constexpr std::size_t error_sources = 4;

/// Standard uncertainties; 0: none.
struct SystematicErrors {
    double ball_mm = 0.0;          ///< of the radius of the ball
    double form_mm = 0.0;          ///< of a point, by the form of the probe: with the direction of the normal
    double constant_mm = 0.0;      ///< of a length, however short it is
    double per_mm = 0.0;           ///< of a length, mm per mm
    double expansion = 0.0;        ///< of all lengths of the part, mm per mm
    double known_expansion = 0.0;  ///< no uncertainty: all lengths are too long by it, mm per mm
    Eigen::Vector3d fixed_at_mm = Eigen::Vector3d::Zero();  ///< from where the part expands and lengths count

    bool any() const;
};

/// How a number answers to each field of errors, times the standard uncertainty of the field; so its variance is the
/// sum of their squares, and loads of several numbers add up with their signs. The last one is the known expansion: not
/// random.
inline constexpr Eigen::Index error_fields = 22;
using FieldLoads = Eigen::Matrix<double, error_fields, 1>;
/// Of shift x, shift y and turn of a plane motion.
using MotionLoads = Eigen::Matrix<double, 3, error_fields>;

double variance_of(const FieldLoads& loads, ErrorSource source);
double variance_of(const FieldLoads& loads);
inline double known_of(const FieldLoads& loads) {
    return loads[error_fields - 1];
}

/// The uncertainty of a number by where it comes from, in its unit; standard, but for what is added to U95 as it is.
struct ErrorBudget {
    double noise = 0.0;  ///< of the points, and of a lean that other sections foretell
    std::array<double, error_sources> machine{};
    double bound = 0.0;  ///< added: 2-D offset, a lean that none foretells, fairing, known expansion not corrected

    double& of(ErrorSource source) { return machine.at(static_cast<std::size_t>(source)); }
    double of(ErrorSource source) const { return machine.at(static_cast<std::size_t>(source)); }
    /// Standard, by the machine's sources together: no number of points makes it less.
    double shared() const;
    ErrorBudget times(double factor) const;
};

/// The errors of one place of a contour along its normal.
struct PlaceErrors {
    std::array<double, error_sources> standard_mm{};
    double known_mm = 0.0;  ///< signed: expansion that is known and not corrected

    double shared_mm() const;  ///< standard, all together
};

/// The fields of errors at a section: displacements of its contour along the normal in its plane, each the same
/// function of place and normal for all sections of a part. A value.
class ErrorFields {
  public:
    ErrorFields() = default;
    ErrorFields(const SystematicErrors& errors, double z_mm) : errors_(errors), z_mm_(z_mm) {}

    const SystematicErrors& errors() const { return errors_; }
    bool any() const { return errors_.any(); }
    /// At a place of a wall that rises by `rise` along its outward normal: the tangent of its lean.
    FieldLoads at(const Vec2& position_mm, const Vec2& normal, double rise) const;
    /// Standard, at such a place: of what differs from place to place of a section, and between sections.
    double place_mm(double rise) const;
    /// Standard: of what differs with the direction of the normal.
    double direction_mm() const;

    /// The part's frame was found by touching these points: with the same machine, so that the frame errs as well.
    void lie_in_frame_of(const SixPoints& points);
    /// Of such a frame (shift, turn about the points' mean): by what is each touch's own, to be added to that of the
    /// touches' scatter; and by what all points have in common, which `at` has taken off.
    static Matrix6 covariance_of_touches(const SystematicErrors& errors, const SixPoints& points);
    Matrix6 covariance_of_frame() const { return frame_ * frame_.transpose(); }

  private:
    using FrameLoads = Eigen::Matrix<double, 6, error_fields>;

    SystematicErrors errors_;
    double z_mm_ = 0.0;
    FrameLoads frame_ = FrameLoads::Zero();  // motion of the part in space, shift and turn about `about_mm_`
    Eigen::Vector3d about_mm_ = Eigen::Vector3d::Zero();
};

}  // namespace cmm::fitting
