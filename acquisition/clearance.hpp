// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"

namespace cmm::acquisition {

/// The part's outline in one plane, coarse (20 um) and closed.
struct Obstacle {
    double z_mm = 0.0;
    std::vector<Eigen::Vector2d> outline;
};

/// Signed distance to a closed polygon: negative inside.
double distance_to_outline(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& outline);

/// Where the stylus may travel: outside an upright box round the whole part anywhere, inside it only straight out of it
/// on a way that no section blocks. The stylus hangs down: ball at its lower end, shank above. A value, millimetres,
/// ball centres.
struct Clearance {
    Eigen::Vector2d low_mm = Eigen::Vector2d::Zero(),
                    high_mm = Eigen::Vector2d::Zero();  ///< the box, clearance and ball included
    double top_mm = 0.0;                                ///< ball centres from here up pass over the part
    StylusSpec stylus;
    std::vector<Obstacle> obstacles;  ///< ascending; empty without a nominal
    std::optional<Eigen::Vector2d>
        way_out;  ///< without obstacles: the direction from the part to the first touch's start

    bool outside(const Eigen::Vector3d& p) const;
    /// Of the box, where it is free whatever stands in it.
    Eigen::Vector3d high_corner_mm() const { return {high_mm.x(), high_mm.y(), top_mm}; }
    /// How far the stylus, ball centre at p, stays from the sections: negative when it cuts them.
    double gap_mm(const Eigen::Vector3d& p) const;
    /// The point of the box's side that is reached straight from p on the way with the most room; nothing when none is
    /// free.
    std::optional<Eigen::Vector2d> way_from(const Eigen::Vector3d& p) const;
    /// Way points after `from` up to and with `to`: out of the box, to the other height, round it, and in. Empty: no
    /// free way.
    std::vector<Eigen::Vector3d> route(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
};

/// `heights` are cut besides an even grid over the nominal's span. Without a nominal the part file's box is taken.
Clearance make_clearance(const PartFile& part, const Nominal* nominal, const std::vector<NominalContour>& cuts);

}  // namespace cmm::acquisition
