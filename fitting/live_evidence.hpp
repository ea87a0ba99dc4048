// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cmm::fitting {

/// Noise of the points and roughness of the curve as the scan goes on: the fixed points of MacKay 1992 (Bayesian
/// interpolation, eq 4.8) with exponential forgetting, the same equations that the batch fit iterates
/// (docs/theory.md, sections 3 and 9). A value of constant size. Millimetres.
class LiveEvidence {
  public:
    /// Variance of a point along the normal, mm^2.
    double noise() const { return noise_; }
    /// Variance that the curvature gains per millimetre, mm^-3.
    double roughness() const { return roughness_; }

    /// A smoothed residual and its leverage (variance of the curve there over the noise).
    void learn_residual(double residual_mm, double leverage);
    /// A smoothed change of curvature over `length_mm` and its posterior variance.
    void learn_change(double change, double variance, double length_mm);

  private:
    static constexpr double start_sigma_mm = 1.5e-3, start_freedom = 2.0, start_roughness = 1e-4;

    double squares_ = start_freedom * start_sigma_mm * start_sigma_mm, freedom_ = start_freedom;
    double noise_ = start_sigma_mm * start_sigma_mm;
    double seen_ = 0.0, known_ = 0.0;  // changes squared over their expectation, and how far they were determined
    double roughness_ = start_roughness;
};

}  // namespace cmm::fitting
