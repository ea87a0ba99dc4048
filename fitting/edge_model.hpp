// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "fitting/edge_shapes.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {

/// A measured ball centre at an edge and what the free-form curve says of it.
struct EdgePoint {
    Vec2 centre = Vec2::Zero();
    Vec2 normal = Vec2::UnitX();  ///< unit, outward, of the free-form curve
    double residual_mm = 0.0;     ///< off that curve
    double leverage = 0.0;        ///< variance of that curve over the variance of a point
};

/// The points of an edge and its surroundings, counter-clockwise.
struct EdgePoints {
    std::vector<EdgePoint> points;
    std::size_t nose = 0;  ///< the point in the middle of the edge
    double ball_mm = 0.0;
    Noise noise;
    std::size_t joints = 0;  ///< of the free-form curve's curvature among them
};

using EdgeShape = std::variant<std::monostate, ArcShape, EllipseShape, DoubleArcShape, ParabolaShape>;

/// What one model makes of the points.
struct ModelTrial {
    EdgeModel model = EdgeModel::free;
    EdgeShape shape;                 ///< none where no fit came about
    std::string why;                 ///< not empty: refused
    std::size_t begin = 0, end = 0;  ///< the points that it explains
    double rms_mm = 0.0;             ///< over the degrees of freedom
    double gain = 0.0;               ///< Bayesian information criterion of the free form less its own, on these points
    Noise noise;                     ///< that the covariance rests on
    Eigen::MatrixXd covariance;      ///< of the shape's parameters; empty with no shape
};

/// The models that were tried, and the one that the points support.
struct EdgeChoice {
    std::vector<ModelTrial> trials;
    std::optional<std::size_t> chosen;  ///< none: free form
};

/// Fits models by orthogonal distances, simplest first, in the widest of some windows about the nose, then as far to
/// either side as they pay. A model is refused whose residuals are larger than the noise allows, follow each other, or
/// hold harmonics that the shape lacks (99.9 % each): then the next one is tried. What is left competes with the
/// free form by the Bayesian information criterion (Schwarz 1978) on the points that it explains, the price of the free
/// form being the trace of its hat matrix there and half of the three numbers of each joint (its place, the steps of
/// the curvature and of its slope), the other half being the side's; a lead of 2 is asked for. With `request` only that
/// model is tried, and chosen only if the points support it.
EdgeChoice choose_edge_model(const EdgePoints& edge, std::optional<EdgeModel> request = {});

}  // namespace cmm::fitting
