// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double flattest_nose = 25.0;       // squared ratio of the semi-axes
constexpr double steepest_hyperbola = 0.25;  // a fit may pass through it, an edge has none
constexpr double longest_radii_ratio = 8.0;

bool between(double value, double limit) {
    return value >= 1.0 / limit && value <= limit;
}

double radius_of_curvature(double c, double radius, double roundness) {
    const double w = conic_support(c * c, roundness);
    return radius / (w * w * w);
}

EllipseShape::Foot ellipse_foot(const auto& frames, int k) {
    EllipseShape::Foot foot;
    foot.normal = frames.normal(k);
    foot.position = frames.position(k);
    foot.slopes << foot.normal, frames.slope_direction(k), frames.slope_radius(k), frames.slope_roundness(k);
    return foot;
}

ParabolaShape::Foot parabola_foot(const auto& frames, int k) {
    ParabolaShape::Foot foot;
    foot.normal = frames.normal(k);
    foot.position = frames.position(k);
    foot.slopes << foot.normal, frames.slope_direction(k), frames.slope_radius(k);
    return foot;
}

}  // namespace

ArcShape::Foot ArcShape::foot(const Vec2& p, const Vec2& near) const {
    const Vec2 centre = values_.head<2>(), off = p - centre;
    const double distance = off.norm();
    Foot foot;
    foot.normal = distance > 0.0 ? Vec2(off / distance) : near;
    foot.position = centre + values_[2] * foot.normal;
    foot.slopes << foot.normal, 1.0;
    return foot;
}

bool EllipseShape::valid() const {
    return values_[3] > 0.0 && values_[4] > -steepest_hyperbola && values_[4] < flattest_nose;
}

VertexConic EllipseShape::conic() const {
    return {values_.head<2>(), axis_, values_[3], values_[4]};
}

EllipseShape::Foot EllipseShape::foot(const Vec2& p, const Vec2& near) const {
    return ellipse_foot(VertexFrames<1>(conic(), &p, &near), 0);
}

void EllipseShape::feet(const Vec2* points, const Vec2* near, Foot* feet) const {
    const VertexFrames<foot_lanes> frames(conic(), points, near);
    for (int k = 0; k < foot_lanes; ++k)
        feet[k] = ellipse_foot(frames, k);
}

double EllipseShape::radius_at(const Vec2& normal) const {
    return radius_of_curvature(normal.dot(axis_), values_[3], values_[4]);
}

VertexConic ParabolaShape::conic() const {
    return {values_.head<2>(), axis_, values_[3], 0.0};
}

ParabolaShape::Foot ParabolaShape::foot(const Vec2& p, const Vec2& near) const {
    return parabola_foot(VertexFrames<1>(conic(), &p, &near), 0);
}

void ParabolaShape::feet(const Vec2* points, const Vec2* near, Foot* feet) const {
    const VertexFrames<foot_lanes> frames(conic(), points, near);
    for (int k = 0; k < foot_lanes; ++k)
        feet[k] = parabola_foot(frames, k);
}

double ParabolaShape::radius_at(const Vec2& normal) const {
    return radius_of_curvature(normal.dot(axis_), values_[3], 0.0);
}

bool DoubleArcShape::valid() const {
    return values_[2] > 0.0 && values_[3] > 0.0 && between(values_[2] / values_[3], longest_radii_ratio);
}

DoubleArcShape::Foot DoubleArcShape::foot(const Vec2& p, const Vec2& near) const {
    const Vec2 first = values_.head<2>(), second = second_centre();
    // The normal where the arcs meet passes through both centres: on its left lie the greater directions.
    const bool on_second = cross(axis_, p - first) > 0.0;
    const Vec2 off = p - (on_second ? second : first);
    const double distance = off.norm();
    Foot foot;
    foot.normal = distance > 0.0 ? Vec2(off / distance) : near;
    foot.position = (on_second ? second : first) + (on_second ? values_[3] : values_[2]) * foot.normal;
    if (!on_second) {
        foot.slopes << foot.normal, 1.0, 0.0, 0.0;
        return foot;
    }
    const double along = foot.normal.dot(axis_);
    foot.slopes << foot.normal, along, 1.0 - along, (values_[2] - values_[3]) * foot.normal.dot(left_of(axis_));
    return foot;
}

}  // namespace cmm::fitting
