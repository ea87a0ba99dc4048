// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/rng.hpp"
#include "fitting/error_fields.hpp"
#include "support/families.hpp"

/// What one machine with its probe does to recorded points, drawn at random or set by hand, by formulas of their own;
/// of cmm::fitting only the numbers that it is told. Millimetres.
namespace cmm::fitting::drawn_errors {

/// Cosine and sine of a wave; nought to begin with.
struct Wave {
    Eigen::Vector2d mm = Eigen::Vector2d::Zero();
};

struct Machine {
    double ball_mm = 0.0;                              ///< by so much the ball is larger than it is held to be
    double constant_mm = 0.0;                          ///< in every direction
    std::array<Wave, 5> lobes;                         ///< by how often they come in a turn of the direction
    std::array<Wave, 6> waves;                         ///< along a section, by how many fit in, less one
    Eigen::Matrix3d strain = Eigen::Matrix3d::Zero();  ///< symmetric: what lengths change by
    double growth = 0.0;                               ///< of the part

    /// Where a ball centre is recorded less where it is; `share` of the outline's length, from anywhere.
    Eigen::Vector3d of(const Eigen::Vector3d& place_mm, const Eigen::Vector3d& normal, double share) const;
};

/// Figures as data sheets have them, E/sqrt(3) each: E0 1.9 + L/300 um, half of a P_Form.Sph and of a P_Size.Sph of
/// 1.9 um; a part of steel whose temperature is known to 0.5 K.
SystematicErrors usual_errors();
/// Of such standard uncertainties, all of them normally distributed, and what is known of the expansion.
Machine draw(const SystematicErrors& errors, core::Rng& rng);
/// The next section of the same part: what differs from place to place differs from section to section.
void draw_waves(const SystematicErrors& errors, core::Rng& rng, Machine& machine);

/// A scan in the plane of that height as this machine records it.
void displace(const families::Blade& blade, const Machine& machine, families::BladeScan& scan, double z_mm = 0.0);

}  // namespace cmm::fitting::drawn_errors
