// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/part_file.hpp"
#include "acquisition/plan.hpp"
#include "drivers/machine.hpp"

/// How a part that nobody knows is found. Part frame = machine frame, mm.
namespace cmm::acquisition {

/// Without `box_mm` the part may be anywhere within the travel, but for the room to go round it.
void bound_by_travel(PartFile& part, const drivers::Capabilities& capabilities);

/// A straight search in the plane of the section.
struct TouchLine {
    Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
};

/// Where a section was first touched: the ball centre there, and the normal out of the material.
struct Entry {
    Eigen::Vector3d contact_mm = Eigen::Vector3d::Zero();
    Eigen::Vector2d outward = Eigen::Vector2d::UnitX();
};

/// The lines to try, in order. With the entry of the section before: along its normal, above it. Else from the plan's
/// start in the plan's direction, then parallel lines on either side, 5 mm apart, as far as the box reaches.
std::vector<TouchLine> touch_lines(const PlannedPath& path, const PartFile& part, const std::optional<Entry>& before);

/// The outward normal from contacts on parallel touches along `direction`; with one contact only: against the
/// direction. A contact that lies farther off than the others allow (over an edge) does not count.
Eigen::Vector2d outward_normal(const Eigen::Vector2d& first, std::span<const Eigen::Vector2d> beside,
                               const Eigen::Vector2d& direction);

/// The entry of a section that was partly measured: from its first points, which run counter-clockwise.
Entry entry_of(std::span<const Eigen::Vector3d> measured);

}  // namespace cmm::acquisition
