// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "fitting/curvature_joints.hpp"
#include "fitting/smoothing_system.hpp"

namespace cmm::fitting {

/// A joint that is known from elsewhere, as from the sections beside.
struct KnownJoint {
    double t = 0.0;
    double step = 0.0;      ///< of the curvature, 1/mm, roughly
    double sigma_mm = 0.0;  ///< standard deviation of its place
};

/// What is known of a closed curve before it is fitted. Parameters count from where the curve begins.
struct KnownShape {
    std::vector<double> breaks;      ///< from 0 once round, without those of joints
    std::vector<KnownJoint> joints;  ///< in order, three breaks or more from each other and from the beginning
    std::vector<double> roughness;  ///< at each break but the last, 1/mm^6 (KnotRoughness); empty: the points must tell
    double roughness_doubt = 1.0;   ///< by how much it may well be larger
};

/// Smooths points on what is known of their curve, and again when more is known: the curvature may jump at the known
/// joints and nowhere else. Value type, one owner.
class KnownFit {
  public:
    /// The points of a curve round from `begin_t`: their parameters are those of before less `begin_t`, in [0, period].
    KnownFit(const SmoothCurve& smooth, double begin_t);

    /// From where the last fit ended; anew where the shape has another number of joints. O(n). Errors:
    /// fit_not_evaluable (a joint without room, singular).
    core::Status fit(const KnownShape& shape);

    /// Whether the curve follows its points (not_followed), but for a few bad ones that were not found.
    bool follows() const;
    /// In order; where the points alone have them, too.
    const std::vector<CurvatureStep>& joints() const { return joints_; }
    /// What the points say of the roughness at a break of the shape, for each but the last; nothing beside joints.
    std::vector<KnotRoughness> roughness(const KnownShape& shape) const;
    std::size_t controls() const { return system_.spans(); }
    /// Whether all controls and joints of another fit are at the same places as this one's, counted.
    bool has_knots_of(const KnownFit& other) const;
    /// See SmoothingSystem::add_to_common.
    void add_to_common(BandSolver<4>& normal, std::vector<double>& moment, double share_of_jumps) const {
        system_.add_to_common(normal, moment, share_of_jumps);
    }
    /// To where others have it as well, and from there to where its own points do. Errors: as fit.
    core::Status move_expected(std::span<const double> displacement);
    /// The curve; the fit is used up.
    SmoothCurve finish() &&;

  private:
    core::Status open(const KnownShape& shape, bool anew);
    core::Status refine(const KnownShape& shape, int count);
    void adopt_roughness(const KnownShape& shape);
    /// Puts the joints where the curve has them now. False when they are there to all intents.
    bool shift(const KnownShape& shape);
    /// How far a joint is known to be from its knots.
    double ahead(const KnownShape& shape, std::size_t joint) const { return shape.joints[joint].t - joints_[joint].t; }

    std::vector<std::size_t> order_;
    Vec2 origin_ = Vec2::Zero();
    std::vector<double> t_;  // at first
    SmoothingSystem system_;
    std::vector<CurvatureStep> joints_;
    std::vector<KnotCluster> knots_;
    bool begun_ = false, roughness_known_ = false;
    double doubt_ = 1.0;
};

/// The breaks of a curve but for those of its joints, once round from where it is to begin: there is one, from 0.
std::vector<double> own_breaks(const SmoothCurve& smooth, double begin_t);

}  // namespace cmm::fitting
