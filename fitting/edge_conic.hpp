// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <variant>

#include "fitting/edge_model.hpp"
#include "fitting/model_fitter.hpp"

namespace cmm::fitting {

/// A conic through a run of an edge's points and how well it is known: an arc, or an ellipse where the Bayesian
/// information criterion (Schwarz 1978) has it.
class EdgeConic {
  public:
    template <class Shape>
    EdgeConic(const OrthogonalFit<Shape>& fit, double sigma_mm)
        : shape_(fit.shape), covariance_(sigma_mm * sigma_mm * inverse_of_small(fit.normal)) {}

    /// The outward unit normal of the part where it is nearest to `p`; `near` is about the same.
    Vec2 normal(const Vec2& p, const Vec2& near) const;
    /// Radius of curvature of the part where it has that normal.
    double radius_mm(const Vec2& normal) const;
    /// Variance of the direction of the normal at `p`, rad^2.
    double direction_variance(const Vec2& p, const Vec2& near) const;

  private:
    std::variant<ArcShape, EllipseShape> shape_;
    Eigen::MatrixXd covariance_;
};

/// Fits conics to runs of one edge's points, each from the one before. One owner; the points must outlive it.
class ConicFitter {
  public:
    /// `curvature`: of the part at each point, 1/mm, as far as it is known.
    ConicFitter(const EdgePoints& edge, std::span<const double> curvature)
        : edge_(edge), curvature_(curvature), fitter_(edge) {}
    /// None where the points of the window leave arcs and ellipses by more than their noise, or systematically.
    std::optional<EdgeConic> fit(const EdgeWindow& window);

  private:
    std::optional<EllipseShape> ellipse_by_curvature(const EdgeWindow& window) const;
    std::optional<OrthogonalFit<EllipseShape>> fit_ellipse(const EdgeWindow& window);

    const EdgePoints& edge_;
    std::span<const double> curvature_;
    ModelFitter fitter_;
    std::optional<EllipseShape> last_;
};

}  // namespace cmm::fitting
