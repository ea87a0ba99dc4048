// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

/// Prismatic blades whose noses are those of a thickness law (as NACA's, thickness with the square root of the distance
/// at both ends): the curvature falls from the nose on and jumps nowhere, so that no joint helps who fits them.
/// Formulas of their own: nothing of cmm::fitting. Millimetres.
namespace cmm::fitting::natural {

using Vec2 = Eigen::Vector2d;

class Blade {
  public:
    /// `slender`: thin and wide as of a fan, otherwise thick and narrow as of a turbine. Sizes by the seed; `le_share`:
    /// of the LE radius that such a thickness has.
    Blade(std::uint64_t seed, bool slender, double le_share = 1.0);

    struct Jet {
        Vec2 position, d1;
        Vec2 normal() const { return Vec2(d1.y(), -d1.x()).normalized(); }  ///< outward
    };
    /// Counter-clockwise; u in [0, 1) from the TE's nose over the suction side, the LE's nose at 0.5.
    Jet at(double u) const;
    /// Signed distance of a point near the outline, positive outside.
    double distance(const Vec2& p) const;
    Vec2 le() const { return at(0.5).position; }
    Vec2 te() const { return at(0.0).position; }
    double le_radius_mm() const { return le_radius_; }

    struct Scan {
        std::vector<Vec2> centres;
        std::vector<double> bad_mm;
        std::size_t le_first = 0;  ///< the first one where the LE's nose is; those before are on the suction side
    };
    /// 600 ball centres, 72 of them where either nose is, `edge_radii` nose radii to both sides, and the others at
    /// equal steps along the sides; 1 um of noise along the normal, 1.5 % bad points, 20 to 400 um off in runs of one
    /// to three.
    Scan scan(std::uint64_t seed, double ball_mm, double edge_radii) const;

  private:
    double chord_, thickness_, camber_, le_radius_, te_radius_, stagger_;
    std::vector<Vec2> samples_;
};

}  // namespace cmm::fitting::natural
