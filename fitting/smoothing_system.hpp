// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/band_solver.hpp"
#include "fitting/least_squares.hpp"
#include "fitting/roughness.hpp"
#include "fitting/smoothing.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// A closed cubic spline, the points that it smooths, and the linear system for its next step: how the offsets of the
/// points and the jumps of the curvature's slope at the knots answer to a normal displacement of its controls
/// (docs/theory.md, section 3). Knot k is break k + 1; control k + a, round the end, weighs function a of span k.
class SmoothingSystem {
  public:
    /// Points in order; `sigma_mm` is a first estimate of their noise along the normal. `supposed_sigma_mm`: of those
    /// that were not measured but are only supposed, 0 of the others; empty when all were measured.
    SmoothingSystem(std::span<const Vec2> points, double sigma_mm, std::span<const double> supposed_sigma_mm = {});

    /// The curve becomes the least-squares spline of the points at parameters `t`, hardly smoothed, and all roughness
    /// starts anew. Errors: fit_not_evaluable.
    core::Status start(std::vector<double> breaks, std::span<const double> t);
    /// The same curve on other breaks (that have the old ones in them, or hardly differ), measured; each knot takes the
    /// roughness of the nearest old one, those in `calm` (old knots) as `Roughness::carry_over` says.
    core::Status change_breaks(std::vector<double> breaks, const std::vector<Roughness::Run>& calm);

    /// Adds to the normal equations of a displacement that all of several curves with as many controls have what this
    /// one's points say of it and, for a share, its jumps.
    void add_to_common(BandSolver<4>& normal, std::vector<double>& moment, double share_of_jumps) const;
    /// The curve is expected to be elsewhere by that, control by control, and moves there: before the next `refine`.
    void move_expected(std::span<const double> displacement);

    /// So many solutions, each with the noise and the roughness that the one before tells; then the curve moves.
    /// Errors: fit_not_evaluable (singular).
    core::Status refine(int count);
    /// Feet and offsets of the points, and the jumps, of the present curve: before the next `refine`.
    void measure();
    /// The second half of it: `slopes`, `lengths_mm`.
    void measure_jumps();
    /// The jump at a knot is expected to be this, not nothing, on these breaks.
    void expect_jump(std::size_t knot, double jump) { expected_[knot] = jump; }

    /// What the next `measure` starts from, to come back to it.
    struct State {
        std::vector<double> breaks, t;
        std::vector<Vec2> controls;
        Roughness roughness;
        double sigma_mm = 0.0;
        double largest_variance_mm2 = 0.0;  ///< of a control across the curve
    };
    State state() const;
    core::Status restore(const State& state);

    std::size_t spans() const { return spans_; }
    const std::vector<double>& breaks() const { return breaks_; }
    const PiecewiseCubic& curve() const { return curve_; }
    Roughness& roughness() { return roughness_; }
    const Roughness& roughness() const { return roughness_; }
    double sigma_mm() const { return sigma_; }
    double freedom() const { return freedom_; }                        ///< effective number of parameters
    const std::vector<double>& slopes() const { return slope_; }       ///< of the curvature by length, a span, 1/mm^2
    const std::vector<double>& lengths_mm() const { return length_; }  ///< of the spans
    const std::vector<double>& parameters() const { return t_; }       ///< of the points' feet
    const std::vector<double>& residuals() const { return residual_; }
    /// Whether the points around a parameter were measured; false where they are only supposed.
    bool was_measured(double t) const;
    /// By the latest solution: variances over sigma_mm^2 of a control across the curve, of the curve in a span where
    /// its functions have these values, and of the curve at a point's foot by its own noise.
    double control_variance(std::size_t control) const { return inverse_[wrapped(control)][0]; }
    double variance(std::size_t span, const std::array<double, 4>& values) const;
    double leverage(std::size_t point) const;
    /// The share of the jump at a knot that the points determine.
    double told(std::size_t knot) const { return told_[knot]; }
    /// The jump at a knot less what was expected.
    double moved(std::size_t knot) const { return moved_[knot]; }
    KnotRoughness told_roughness(std::size_t knot) const {
        if (roughness_.held(knot)) return {};
        return {moved_[knot] * moved_[knot] / mean_length_mm(knot), told_[knot]};
    }
    /// Of the spans to either side of a knot.
    double mean_length_mm(std::size_t knot) const { return 0.5 * (length_[knot] + length_[wrapped(knot + 1)]); }
    /// Of the change of the curvature from one parameter to another, 1/mm^2 (not over sigma_mm^2). O(controls).
    double step_variance(double from_t, double to_t) const;
    const CubicBasis& basis(std::size_t span) const { return least_squares_.basis(span); }

    /// The number of a point that is only supposed.
    static constexpr std::size_t supposed = ~std::size_t{0};
    /// The measured curve with its joints. `order`: which point of the result is which of the system's; `origin`: of
    /// its coordinates. The uncertainty is that of a curve `doubt` times as rough. The system is used up.
    SmoothCurve finish(std::vector<CurvatureStep> joints, std::span<const std::size_t> order, const Vec2& origin,
                       double doubt) &&;

  private:
    using Four = std::array<double, 4>;
    using Five = std::array<double, 5>;

    std::size_t wrapped(std::size_t control) const { return control < spans_ ? control : control - spans_; }
    std::size_t before(std::size_t control, std::size_t by) const {
        return control >= by ? control - by : control + spans_ - by;
    }
    double width(std::size_t span) const { return breaks_[span + 1] - breaks_[span]; }
    template <class Work>
    void for_each_run(const Work& work) const;
    template <int Count>
    struct Lanes;
    template <int Count>
    void move_feet(std::size_t span, std::size_t first);
    template <int Count>
    void measure_residuals(std::size_t span, std::size_t first);
    void measure_points();
    double weight_of(std::size_t point) const;
    void sum_points();
    double jump_weight(std::size_t knot, double noise) const;
    bool solve(double times = 1.0);
    void tune();
    void move();
    void set_curve();
    CurveNoise noise(double doubt) &&;

    std::vector<double> x_, y_, t_, residual_;
    std::vector<double> supposed_;  // standard deviations; 0 of points that were measured; empty when all were
    double measured_ = 0.0;         // number of points
    std::vector<std::uint32_t> span_;
    std::vector<Four> basis_;
    double sigma_ = 0.0, freedom_ = 0.0;

    std::size_t spans_ = 0;
    std::vector<double> breaks_;
    LeastSquaresSpline least_squares_;
    std::vector<Vec2> controls_;
    PiecewiseCubic curve_;
    std::vector<double> length_, slope_, jump_;  // of the curvature by length: per span, and scaled jump per knot
    std::vector<double> expected_;               // jumps
    std::vector<Four> slope_row_;
    std::vector<Five> jump_row_, weighted_row_;
    std::vector<Four> gram_;  // of controls k and k, k - 1, k - 2, k - 3, by the points
    std::vector<double> moment_;
    double residual_squares_ = 0.0;
    BandSolver<4> normal_;
    std::vector<BandSolver<4>::Row> inverse_;
    std::vector<double> displacement_, moved_, told_;
    Roughness roughness_;
};

/// So many solutions settle noise and roughness where the points alone tell them.
inline constexpr int free_tunings = 9;
/// exp(1): the logarithm of a variance that two degrees of freedom tell has the variance 1, and a knot and those that
/// share its scale tell hardly more of theirs. The uncertainty is that of a curve so much rougher than is likeliest.
inline constexpr double own_roughness_doubt = 2.72;
/// Finer noise is not resolved.
inline constexpr double least_sigma_mm = 2e-5;

}  // namespace cmm::fitting
