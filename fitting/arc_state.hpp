// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "fitting/vec2.hpp"

/// A curve known at one point and how surely, carried from point to point: an intrinsic Kalman filter and its smoother
/// (docs/theory.md, section 9). Plane coordinates, millimetres, left is positive. Pure functions of values.
namespace cmm::fitting {

/// Symmetric 3 x 3 matrix over (displacement, slope, curvature).
struct Symmetric3 {
    double dd = 0.0, ds = 0.0, dc = 0.0, ss = 0.0, sc = 0.0, cc = 0.0;
};
using Triple = std::array<double, 3>;
using Matrix3 = std::array<Triple, 3>;

struct ArcState {
    Vec2 position = Vec2::Zero();
    Vec2 tangent = Vec2::UnitX();  ///< unit, direction of travel
    double curvature = 0.0;        ///< 1/mm
    Symmetric3 covariance;         ///< of a displacement d along the left normal, of d' and of the curvature
};

/// A point seen from a state: its foot on the arc of the state's curvature.
struct ArcFoot {
    bool reached = false;          ///< false: the arc does not come past the point within a quarter turn
    double length = 0.0;           ///< along the arc to the foot, mm, negative backwards
    double offset = 0.0;           ///< of the point from the arc, mm, positive to the left
    Vec2 tangent = Vec2::UnitX();  ///< of the arc at the foot
    double turn = 0.0;             ///< of the arc, rad
    double cosine = 1.0;           ///< of the turn
    double reach = 0.0;            ///< sine of the turn over the curvature, mm
};
ArcFoot foot_on_arc(const ArcState& state, const Vec2& point);

/// Variance of the displacement at the foot without process noise.
double carried_variance(const ArcState& state, const ArcFoot& foot);

/// Covariance at the foot when the curvature is a Wiener process of variance `rate` per millimetre.
Symmetric3 carried_covariance(const ArcState& state, const ArcFoot& foot, double rate);

/// Share of the displacement's variance in that process noise: rate |length|^5 / 20.
double process_variance(double rate, double length);

/// The state moved by a displacement (d, d', change of curvature) across its own normal; the covariance stays.
ArcState displaced(const ArcState& state, const Triple& by);

/// What a point says of the curve (Kalman 1960): the state at its foot, and by how much the point has displaced it.
struct ArcUpdate {
    ArcState state;
    Triple correction{};
};
/// `predicted` is the covariance at the foot, `noise` the variance of the point across the curve.
ArcUpdate updated(const ArcState& before, const ArcFoot& foot, const Vec2& point, const Symmetric3& predicted,
                  double noise);

/// Gain of the backward step (Rauch, Tung, Striebel 1965): P F' (P-)^-1 with the predicted covariance P-.
Matrix3 backward_gain(const ArcState& state, const ArcFoot& foot, const Symmetric3& predicted);

Triple product(const Matrix3& m, const Triple& v);
/// P + G (later - predicted) G'.
Symmetric3 smoothed_covariance(const Symmetric3& p, const Matrix3& gain, const Symmetric3& later,
                               const Symmetric3& predicted);

}  // namespace cmm::fitting
