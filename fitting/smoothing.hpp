// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/band_solver.hpp"
#include "fitting/cubic_basis.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// The curve's standard uncertainty from the noise of the points, everywhere: posterior variance of the normal
/// displacement (docs/theory.md, section 3). Value type; copies share the factored system.
class CurveNoise {
  public:
    /// Of a band matrix elements (k, k) ... (k, k + 3) or (k, k - 3), round the end. There are many, and nothing is
    /// solved with them.
    using Row = std::array<float, 4>;

    CurveNoise() = default;
    /// `knots`: the breaks with three more at either end, round the curve. `normal` is factored; the covariance of the
    /// controls is its inverse times the square of sigma_mm. `gram` is what the points have of it: its elements (k, k),
    /// (k, k - 1), ... (k, k - 3), round the beginning.
    CurveNoise(std::vector<double> knots, std::vector<Row> covariance, std::shared_ptr<const BandSolver<4>> normal,
               std::vector<Row> gram, double sigma_mm);

    /// From place to place: those that follow each other in a span share its basis, which is kept nowhere else.
    class Walk {
      public:
        explicit Walk(const CurveNoise& noise) : noise_(noise) {}

        /// Standard deviation in mm of the curve at parameter t, across the curve; t within the period.
        double sigma_mm(double t);
        /// For numbers that depend on the curve at many places, whose errors go together: how much such a number
        /// changes with each control. First as many zeros as there are controls, then one call for each place.
        void add_place(double t, double weight, std::span<double> slopes);

      private:
        std::array<double, 4> functions_at(double t);

        const CurveNoise& noise_;
        std::size_t span_ = ~std::size_t{0};
        double low_ = 0.0, high_ = 0.0;  // where it begins and ends
        CubicBasis basis_{};
    };
    double sigma_mm(double t) const { return Walk(*this).sigma_mm(t); }

    std::size_t controls() const { return covariance_.size(); }
    /// Of a number, mm^2 times the square of its slopes.
    struct Variance {
        double scatter = 0.0;  ///< from one measurement of the curve to the next
        double kept = 0.0;     ///< what the prior may keep it from, the same every time
        double sum() const { return scatter + kept; }
    };
    /// O(controls); `slopes` are used up.
    Variance variance(std::span<double> slopes) const;
    /// From how a number depends on each control to its covariance with each, mm^2 times its slopes. O(controls).
    void covary(std::span<double> slopes) const;

  private:
    std::size_t wrapped(std::size_t control) const { return control < controls() ? control : control - controls(); }

    std::vector<double> knots_;
    std::vector<Row> covariance_;  // of controls k and k ... k + 3, round the end, mm^2
    std::shared_ptr<const BandSolver<4>> normal_;
    std::shared_ptr<const std::vector<Row>> gram_;
    double point_sigma_mm_ = 0.0;
};

/// The curvature changes at once.
struct CurvatureStep {
    double t = 0.0;              ///< parameter
    double step = 0.0;           ///< by so much, 1/mm
    double told_t = 0.0;         ///< where the points alone have it, whatever was known before ...
    double told_sigma_mm = 0.0;  ///< ... and the standard deviation of that
};

/// A closed smoothing spline through noisy points (docs/theory.md, "The centre curve").
struct SmoothCurve {
    PiecewiseCubic curve;
    std::vector<double> parameter;  ///< of each input point on `curve`
    std::vector<double> residual;   ///< signed, along the right-hand normal (outward when counter-clockwise), mm
    std::vector<double> leverage;   ///< of each point on its own foot: the variance of a residual is s^2 (1 - leverage)
    double sigma_mm = 0.0;          ///< standard deviation of a point along the normal, estimated
    double freedom = 0.0;           ///< effective number of parameters: the sum of the leverages
    std::vector<CurvatureStep> joints;  ///< where the curvature jumps, in order
    CurveNoise noise;
};

/// Where a curve may be supposed to go, with the standard deviation of that.
struct SupposedPoint {
    Vec2 position = Vec2::Zero();
    double sigma_mm = 0.0;
};

/// Supposed points where nothing was measured behind point `before`: they keep the curve from going astray there and
/// weigh next to nothing beside what was measured.
struct GapBridge {
    std::size_t before = 0;
    std::vector<SupposedPoint> points;
};

/// Fits points that go round once, counter-clockwise, in order; `bridges` in their order. Nothing is told about the
/// noise: the strength of the smoothing follows from the points, locally (docs/theory.md, section 3). O(n). Errors:
/// fit_not_evaluable (fewer than 12 points, singular).
core::Result<SmoothCurve> smooth_closed(std::span<const Vec2> points, std::span<const GapBridge> bridges = {});

}  // namespace cmm::fitting
