// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "fitting/lane_bits.hpp"
#include "fitting/surface.hpp"

namespace cmm::fitting {

/// A rectangle of a surface within one span of either direction.
struct PatchDomain {
    std::size_t span_u = 0, span_v = 0;
    double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;

    bool holds(const SurfacePlace& at) const { return at.u >= u0 && at.u <= u1 && at.v >= v0 && at.v <= v1; }
    SurfacePlace clamped(const SurfacePlace& at) const;
};

/// What is certain about a patch S(x, y), x and y in [0, 1], from the hulls of the Bezier points of S and of its
/// derivatives: a parallelogram it stays close to, and bounds of the second derivatives of |S - p|^2 / 2.
class PatchBounds {
    friend class PatchGroup;

  public:
    PatchBounds() = default;
    PatchBounds(const Surface& surface, const PatchDomain& domain);

    /// Nothing of the patch is nearer to p than this: distance to the parallelogram less the deviation from it, mm.
    double least_distance(const Vec3& p) const;
    /// Whether that is less than `limit`, for less work.
    bool nearer_than(double limit, const Vec3& p) const;
    /// |S - p|^2 is convex on the patch: then it has one minimum there.
    bool convex_for(const Vec3& p) const;

    const PatchDomain& domain() const { return domain_; }
    const Vec3& low() const { return low_; }
    const Vec3& high() const { return high_; }
    /// By how much the tangents turn from one end in u (in v) to the other, estimated; rad. Halving that way halves it.
    double turn_u() const { return turn_u_; }
    double turn_v() const { return turn_v_; }

  private:
    using Grid = std::array<std::array<Vec3, 4>, 4>;
    void bound_shape(const Grid& points);
    void bound_bending(const Grid& points);
    double square_to_parallelogram(const Vec3& from_centre) const;

    PatchDomain domain_;
    Vec3 centre_, normal_, across_a_, across_b_;  // of the parallelogram: unit normal of its plane and of its strips
    double half_a_ = 0.0, half_b_ = 0.0, cosine_ = 0.0, wedge_ = 0.0, reach_ = 0.0, deviation_ = 0.0;
    /// Second derivatives: mean, radius of their hull, least (or largest magnitude) of what does not depend on p.
    struct Bending {
        Vec3 mean = Vec3::Zero();
        double radius = 0.0, constant = 0.0;
    };
    Bending uu_, uv_, vv_;
    Vec3 low_, high_;
    double turn_u_ = 0.0, turn_v_ = 0.0;
};

/// The parallelograms of eight patches in single precision, for a first look at all of them at once.
class PatchGroup {
  public:
    static constexpr std::size_t size = lane_count;
    using Lanes = FloatLanes;

    void set(std::size_t lane, const PatchBounds& patch);
    /// PatchBounds::least_distance from the parallelogram alone, too large by no more than single precision costs:
    /// 2^-19 of the largest coordinate. Lanes that were not set tell nothing.
    Lanes least_distances(const std::array<float, 3>& p) const;

  private:
    struct Vectors {
        Lanes x = Lanes::Zero(), y = Lanes::Zero(), z = Lanes::Zero();
    };
    Vectors centre_, normal_, across_a_, across_b_;
    Lanes half_a_ = Lanes::Zero(), half_b_ = Lanes::Zero(), deviation_ = Lanes::Zero();
};

}  // namespace cmm::fitting
