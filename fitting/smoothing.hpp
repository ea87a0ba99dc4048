// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/cubic_basis.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// How freely the roughness of the curve may change from place to place.
enum class Stiffness : std::uint8_t {
    supple,  ///< at once: corners and ends of arcs are followed
    stiff,   ///< slowly: a run of bad points stands out
};

/// The curve's standard uncertainty from the noise of the points, everywhere: posterior variance of the normal
/// displacement (docs/theory.md, section 3). Value type.
class CurveNoise {
  public:
    CurveNoise() = default;
    CurveNoise(std::vector<double> breaks, std::vector<CubicBasis> bases,
               std::vector<std::array<double, 4>> covariance);

    /// Standard deviation in mm of the curve at parameter t, across the curve; t within the period.
    double sigma_mm(double t) const;

  private:
    std::vector<double> breaks_;
    std::vector<CubicBasis> bases_;
    std::vector<std::array<double, 4>> covariance_;  // of controls k and k ... k + 3, round the end, mm^2
};

/// A closed smoothing spline through noisy points (docs/theory.md, "The centre curve").
struct SmoothCurve {
    PiecewiseCubic curve;
    std::vector<double> parameter;  ///< of each input point on `curve`
    std::vector<double> residual;   ///< signed, along the right-hand normal (outward when counter-clockwise), mm
    std::vector<double> leverage;   ///< of each point on its own foot: the variance of a residual is s^2 (1 - leverage)
    double sigma_mm = 0.0;          ///< standard deviation of a point along the normal, estimated
    double freedom = 0.0;           ///< effective number of parameters: the sum of the leverages
    CurveNoise noise;
};

/// Fits points that go round once, counter-clockwise, in order. Nothing is told about the noise: the strength of the
/// smoothing follows from the points, locally (docs/theory.md, section 3). O(n). Errors: fit_not_evaluable (fewer than
/// 12 points, singular).
core::Result<SmoothCurve> smooth_closed(std::span<const Vec2> points, Stiffness stiffness = Stiffness::supple);

}  // namespace cmm::fitting
