// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A plane cubic NURBS curve (seed 000, eq 6-7): clamped knots u_0 = ... = u_3 <= ... <= u_{m}, m = controls + 3.
/// Value type, any thread; parameter in [0, 1].
class NurbsCurve {
  public:
    NurbsCurve(std::vector<double> knots, std::vector<Vec2> controls, std::vector<double> weights);

    Vec2 position(double u) const;
    Vec2 derivative(double u) const;

    const std::vector<double>& knots() const { return knots_; }
    const std::vector<Vec2>& controls() const { return controls_; }
    const std::vector<double>& weights() const { return weights_; }

  private:
    struct Homogeneous {
        Vec2 weighted = Vec2::Zero(), weighted_d = Vec2::Zero();
        double weight = 0.0, weight_d = 0.0;
    };
    Homogeneous evaluate(double u) const;

    std::vector<double> knots_;
    std::vector<Vec2> controls_;
    std::vector<double> weights_;
};

/// How an interpolating curve ends.
struct EndConditions {
    std::optional<Vec2> start_tangent;  ///< direction; its length is set to the chord parameter's speed. None: natural
    std::optional<Vec2> end_tangent;
};

/// The cubic NURBS through q_1 ... q_n at cumulative chord lengths (seed 000, eq 8-14, with the corrections of
/// docs/theory.md). `weights` are the data weights (empty: all 1), their end slopes are zero: with equal weights the
/// result is the non-rational C2 spline. Errors: fit_not_evaluable (fewer than 2 points, repeated points, weights <= 0,
/// weights whose control weights are not positive).
core::Result<NurbsCurve> interpolate_nurbs(std::span<const Vec2> points, std::span<const double> weights,
                                           const EndConditions& ends);

}  // namespace cmm::fitting
