// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/section_result.hpp"
#include "core/error.hpp"
#include "fitting/section.hpp"

namespace cmm::acquisition {

struct EvaluationOptions {
    std::optional<double> profile_mm;       ///< full width of the zone about the sides; absent: reported, not judged
    std::optional<double> edge_profile_mm;  ///< of LE and TE
    double ball_radius_mm = 0.0;
    double lean_rad = 0.0;  ///< largest angle of the surface to the section's normal plane (A22)
};

/// ISO 14253-1 with a 95 % one-sided guard band: accept when value + g <= limit, reject when value - g > limit,
/// otherwise undecided; g = 1.65/2 of the expanded uncertainty.
Decision decide(double value_mm, double u95_mm, double limit_mm);
double guard_band_mm(double u95_mm);

/// Signed distance of each contour point to the closed nominal curve (positive: too much material), foot on the side
/// whose outward normal agrees with the point's, so that a thin edge is never compared with its other side. Errors:
/// fit_not_evaluable (the nominal is not a closed curve).
core::Result<std::vector<double>> deviations_mm(std::span<const fitting::ContourPoint> contour,
                                                std::span<const Eigen::Vector2d> nominal);

/// Judges a section. `section` brings index, name, z and points; the fit's verdicts are copied to the points. A failed
/// or open fit leaves every characteristic not evaluable. `nominal` is closed and counter-clockwise; empty: no nominal,
/// then there are no profile characteristics. Uncertainty: that of the fit, and, added as a bound because its sign is
/// known and it is not corrected, the 2-D offset error r (1 - cos lean) per surface point. Pure; any thread.
SectionResult evaluate_section(SectionResult section, core::Result<fitting::SectionFit> fit,
                               std::span<const Eigen::Vector2d> nominal, const EvaluationOptions& options);

}  // namespace cmm::acquisition
