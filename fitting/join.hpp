// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "fitting/edge_model.hpp"
#include "fitting/spline.hpp"

namespace cmm::fitting {

/// The way from an edge's model to the free-form curve of a side: y = polynomial of degree five or less in x, in the
/// frame of the joint (x along the side, y outwards). It leaves the model with its tangent and reaches the free form
/// with its tangent and curvature; the curvature on its way out of the joint is the side's, from the points.
struct Bridge {
    double t_joint = 0.0, t_free = 0.0;  ///< on the free-form curve, t_joint the nearer to the nose
    Vec2 joint = Vec2::Zero(), along = Vec2::UnitX(), outward = Vec2::UnitY();
    double length_mm = 0.0;
    std::array<double, 5> y{};  ///< of (x/length)^2 ... (x/length)^6

    Vec2 place(const Vec2& p) const;
};

/// A model that replaces the free form about a nose, with a bridge to either side. Of the curve of ball centres.
struct EdgePatch {
    EdgeShape shape;
    double ball_mm = 0.0;
    Eigen::MatrixXd covariance;  ///< of the shape's parameters
    Bridge before, after;  ///< before.t_free < before.t_joint < after.t_joint < after.t_free; may pass the period's end

    /// What the joined curve's place across itself at parameter t, where the outward normal is `normal`, depends on:
    /// the shape's parameters, and the free form there. On the model the parameters alone, on a bridge both, from those
    /// of the joint to the free form; nothing outside the patch.
    struct Dependence {
        Eigen::VectorXd on_model;
        double on_free = 0.0;
    };
    std::optional<Dependence> dependence(double t, double period, const Vec2& part_point, const Vec2& normal) const;

    /// What the joined curve goes through, in no order; the bridges' ends are on the curve.
    struct Place {
        double t;  ///< may pass the period's end
        Vec2 position;
    };
    std::vector<Place> places(const PiecewiseCubic& curve) const;

    /// The standard uncertainty that follows; `free_mm` is that of the free form there.
    std::optional<double> sigma_mm(double t, double period, const Vec2& part_point, const Vec2& normal,
                                   double free_mm) const;
};

/// Places both joints of a model where the points want them and builds the bridges (seed 000, A21: where the paper
/// meets the side with the arc's tangent and inserted points, the joint here is the place on the model from which the
/// least squares of points and bridge are smallest, so that it always exists). `t` are the parameters of the edge's
/// points on the curve, ascending. Nothing where there is no room.
std::optional<EdgePatch> make_patch(const PiecewiseCubic& curve, const EdgePoints& edge, std::span<const double> t,
                                    const ModelTrial& trial);

/// Replaces the curve inside the patches: the cubic spline through points of model, bridges and free form, C2. Outside
/// the patches the curve is kept, the parameter everywhere.
PiecewiseCubic join_edges(const PiecewiseCubic& curve, std::span<const EdgePatch> patches);

}  // namespace cmm::fitting
