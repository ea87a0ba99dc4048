// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/measured_section.hpp"

namespace cmm::fitting {

struct BestFitOptions {
    bool translate = true, rotate = true;               ///< false: held at zero
    std::array<bool, 4> zones{true, true, true, true};  ///< that take part, by Zone
};

/// How a measured section lies to its nominal: the nominal, turned by `twist_rad` about `about_mm` (the nominal's
/// centre of area) counter-clockwise and then moved by `shift_mm`, is nearest to the contour.
struct BestFit {
    Vec2 about_mm = Vec2::Zero(), shift_mm = Vec2::Zero();
    double twist_rad = 0.0;
    double rms_mm = 0.0;  ///< of the deviations that are left, by arc length
    int rounds = 0;
    Measure dx, dy, twist;  ///< with what they depend on

    /// Where a point of the contour lies in the nominal's frame.
    Vec2 in_nominal(const Vec2& p) const;
    Vec2 direction_in_nominal(const Vec2& v) const;
};

/// Least squares of the distances along the normals of the nominal, each point weighing the length of contour that it
/// stands for, so that a densely measured edge does not outweigh a side: closest points and a Gauss-Newton step in turn
/// (Chen and Medioni 1992) until it moves by less than 1e-10. `use`: not of a point means that it takes no part (empty:
/// all); nor do those whose nearest place on the nominal faces the other way. Errors: fit_not_evaluable (fewer than 12
/// points, a motion that they do not determine, no convergence).
core::Result<BestFit> fit_to_nominal(const ContourGeometry& contour, const ClosedCurve& nominal,
                                     const BestFitOptions& options = {}, std::span<const char> use = {});

}  // namespace cmm::fitting
