// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "fitting/edge_kind.hpp"
#include "fitting/vec2.hpp"
#include "fitting/vertex_frames.hpp"

/// The forms that drawings give to leading and trailing edges (seed 000, A10), as curves of the part with exact foot
/// points. All are convex and run counter-clockwise; their points are told apart by the direction of the outward
/// normal. Millimetres, radians, plane frame of the section. Values; any thread.
namespace cmm::fitting {

/// The point of a shape that is nearest to a given one.
template <int Size>
struct ShapeFoot {
    Vec2 position = Vec2::Zero();
    Vec2 normal = Vec2::UnitX();            ///< unit, outward
    Eigen::Matrix<double, Size, 1> slopes;  ///< of the foot's place along its normal, by the shape's parameters
};

/// What the shapes have in common: parameters, and one direction whose sine and cosine are kept.
template <int Size>
class ShapeBase {
  public:
    static constexpr int size = Size;
    using Values = Eigen::Matrix<double, Size, 1>;
    using Foot = ShapeFoot<Size>;

    const Values& values() const { return values_; }

  protected:
    ShapeBase(const Values& values, double angle) : values_(values), axis_(std::cos(angle), std::sin(angle)) {}
    Values values_;
    Vec2 axis_;
};

/// Every shape has `foot(p, near)`: the nearest point to p, `near` being the unit normal there as far as it is known;
/// exact for points outside and for those inside that are nearer than the least radius of curvature. `radius_at` is
/// the radius of curvature where the outward unit normal has the given direction. Where Newton looks for the foot,
/// `feet` finds those of `foot_lanes` points at a time, the same to the last bit.
constexpr int foot_lanes = 8;

/// Parameters: centre x, centre y, radius.
class ArcShape : public ShapeBase<3> {
  public:
    static constexpr EdgeModel model = EdgeModel::arc;
    explicit ArcShape(const Values& values) : ShapeBase(values, 0.0) {}
    bool valid() const { return values_[2] > 0.0; }
    Foot foot(const Vec2& p, const Vec2& near) const;
    double radius_at(const Vec2&) const { return values_[2]; }
};

/// A conic by its vertex at the nose: y^2 = 2 radius depth - roundness depth^2, depth running inwards along the axis.
/// Roundness is the squared ratio of the semi-axis across to that along: 1 a circle, 0 a parabola, above 1 a flattened
/// nose; 0 is no singular place, so that a fit may pass it. Parameters: vertex x, vertex y, direction of the axis out
/// of the vertex, radius of curvature at the vertex, roundness.
class EllipseShape : public ShapeBase<5> {
  public:
    static constexpr EdgeModel model = EdgeModel::ellipse;
    explicit EllipseShape(const Values& values) : ShapeBase(values, values[2]) {}
    bool valid() const;
    double semi_axis_along() const { return values_[3] / values_[4]; }
    double semi_axis_across() const { return values_[3] / std::sqrt(values_[4]); }
    VertexConic conic() const;
    Foot foot(const Vec2& p, const Vec2& near) const;
    void feet(const Vec2* points, const Vec2* near, Foot* feet) const;
    double radius_at(const Vec2& normal) const;
};

/// Parameters: vertex x, vertex y, direction of the axis out of the vertex, radius of curvature at the vertex.
class ParabolaShape : public ShapeBase<4> {
  public:
    static constexpr EdgeModel model = EdgeModel::parabola;
    explicit ParabolaShape(const Values& values) : ShapeBase(values, values[2]) {}
    bool valid() const { return values_[3] > 0.0; }
    VertexConic conic() const;
    Foot foot(const Vec2& p, const Vec2& near) const;
    void feet(const Vec2* points, const Vec2* near, Foot* feet) const;
    double radius_at(const Vec2& normal) const;
};

/// Two arcs with one tangent where they meet. Parameters: first centre x, first centre y, first radius, second radius,
/// direction of the normal where they meet; the first arc has the lesser directions.
class DoubleArcShape : public ShapeBase<5> {
  public:
    static constexpr EdgeModel model = EdgeModel::double_arc;
    explicit DoubleArcShape(const Values& values) : ShapeBase(values, values[4]) {}
    bool valid() const;
    Vec2 second_centre() const { return Vec2(values_.head<2>()) + (values_[2] - values_[3]) * axis_; }
    Foot foot(const Vec2& p, const Vec2& near) const;
    double radius_at(const Vec2& normal) const { return cross(axis_, normal) > 0.0 ? values_[3] : values_[2]; }
};

}  // namespace cmm::fitting
