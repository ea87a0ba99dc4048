// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fitting/join.hpp"
#include "fitting/plane_error.hpp"
#include "fitting/plane_motion.hpp"
#include "fitting/sensitivity.hpp"
#include "fitting/smoothing.hpp"

namespace cmm::fitting {

struct ContourPoint;

/// The uncertainty of a number that was computed from a contour.
struct NumberUncertainty {
    double standard = 0.0;      ///< one standard deviation
    double u95 = 0.0;           ///< half the 95 % interval, bounds included
    double offset_error = 0.0;  ///< part of u95: what the 2-D offset makes of it (A22), whose sign is known
};

/// The errors of a section's contour as a whole, so that those of neighbouring places go together (docs/theory.md,
/// section 13): of the free form by the posterior covariance of the smoothing spline, at the edges by that of their
/// models' parameters. Value type; refers to nothing.
class ContourNoise {
  public:
    /// Nothing is known but the points' own u95.
    ContourNoise() = default;
    /// `period` of the curve's parameter; `coverage` makes a 95 % interval of a standard deviation.
    ContourNoise(CurveNoise free, std::vector<EdgePatch> patches, double period, double coverage);

    double coverage() const { return coverage_; }
    /// The contour was moved since: `motion` leads from where it is to where the noise was found.
    void lies_in(const PlaneMotion& motion) { from_contour_ = motion; }
    /// The plane of the section is not where it should be by this.
    void take(PlaneError plane) { plane_ = std::move(plane); }
    /// Of a number by that alone.
    double plane_variance(const Sensitivity& number) const { return plane_.variance(number); }
    /// From the noise of the points alone, in the square of the number's unit. Where nothing is known, the points' own
    /// u95 fully correlated, which is never too small.
    double variance(std::span<const ContourPoint> contour, const Sensitivity& number) const;
    /// With the error of the plane, with what the neighbouring sections took, correlated over an eighth of the section,
    /// and with the bounds, which are added. `own_variance`: of what is not in the contour (the radius of an edge's
    /// circle), independent.
    NumberUncertainty of(std::span<const ContourPoint> contour, const Sensitivity& number,
                         double own_variance = 0.0) const;

  private:
    std::optional<CurveNoise> free_;
    std::vector<EdgePatch> patches_;
    double period_ = 0.0, coverage_ = 2.0;
    PlaneMotion from_contour_;
    PlaneError plane_;
};

}  // namespace cmm::fitting
