// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double flattest_nose = 25.0;       // squared ratio of the semi-axes
constexpr double steepest_hyperbola = 0.25;  // a fit may pass through it, an edge has none
constexpr double longest_radii_ratio = 8.0;
constexpr int most_newton_steps = 30;
constexpr double last_newton_step = 1e-4;  // of the normal: the next would be below 1e-8

bool between(double value, double limit) {
    return value >= 1.0 / limit && value <= limit;
}

/// w^2 of a conic at the angle psi of the normal to its axis, c = cos(psi): kept above zero beyond the directions that
/// a hyperbola's normals take.
double support(double c2, double roundness) {
    return std::sqrt(std::max(c2 + roundness * (1.0 - c2), 1e-4));
}

double radius_of_curvature(double c, double radius, double roundness) {
    const double w = support(c * c, roundness);
    return radius / (w * w * w);
}

/// The foot on a conic, in the frame of its vertex. By the angle psi of the normal to the axis, c its cosine and s its
/// sine, w = sqrt(c^2 + roundness s^2), the conic is depth = radius s^2/(w (w + c)), y = radius s/w, and its radius of
/// curvature radius/w^3: regular for circle, parabola and everything between. The foot's normal is where p - C has no
/// tangential part; Newton's step for psi is that part over (radius of curvature + distance).
struct VertexFrame {
    Vec2 normal, position;
    double c, s, w, radius, depth = 0.0, y = 0.0;

    VertexFrame(const Vec2& p, const Vec2& near, const Vec2& vertex, const Vec2& axis, double vertex_radius,
                double roundness)
        : c(near.dot(axis)), s(cross(axis, near)), w(1.0), radius(vertex_radius) {
        const Vec2 side = left_of(axis);
        const double u = (p - vertex).dot(axis), v = (p - vertex).dot(side);
        for (int step = 0; step < most_newton_steps; ++step) {
            w = support(c * c, roundness);
            depth = radius * s * s / (w * std::max(w + c, 1e-3));
            y = radius * s / w;
            const double du = u + depth, dv = v - y;
            const double speed = radius / (w * w * w), stretch = speed + c * du + s * dv;
            const double turn = std::clamp((c * dv - s * du) / std::max(stretch, 0.1 * speed), -0.3, 0.3);
            if (std::abs(turn) < 1e-12) break;
            const double scale = 1.0 / std::sqrt(1.0 + turn * turn), turned = (c - s * turn) * scale;
            s = (s + c * turn) * scale;
            c = turned;
            if (std::abs(turn) < last_newton_step) break;
        }
        w = support(c * c, roundness);
        depth = radius * s * s / (w * std::max(w + c, 1e-3));
        y = radius * s / w;
        normal = c * axis + s * side;
        position = vertex - depth * axis + y * side;
    }

    double slope_direction() const { return -(c * y + s * depth); }
    double slope_radius() const { return s * s / (w + c); }
    double slope_roundness() const { return -radius * s * s * s * s / (2.0 * w * (w + c) * (w + c)); }
};

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

EllipseShape::Foot EllipseShape::foot(const Vec2& p, const Vec2& near) const {
    const VertexFrame at(p, near, values_.head<2>(), axis_, values_[3], values_[4]);
    Foot foot;
    foot.normal = at.normal;
    foot.position = at.position;
    foot.slopes << at.normal, at.slope_direction(), at.slope_radius(), at.slope_roundness();
    return foot;
}

double EllipseShape::radius_at(const Vec2& normal) const {
    return radius_of_curvature(normal.dot(axis_), values_[3], values_[4]);
}

ParabolaShape::Foot ParabolaShape::foot(const Vec2& p, const Vec2& near) const {
    const VertexFrame at(p, near, values_.head<2>(), axis_, values_[3], 0.0);
    Foot foot;
    foot.normal = at.normal;
    foot.position = at.position;
    foot.slopes << at.normal, at.slope_direction(), at.slope_radius();
    return foot;
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
