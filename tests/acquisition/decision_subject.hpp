// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "acquisition/plan.hpp"
#include "acquisition/section_setup.hpp"
#include "support/families.hpp"

/// A simulated blade as the product sees it: nominal, limits, and the path that the planner drives.
namespace cmm::acquisition::decisions {

inline constexpr double half_zone_mm = 0.020;
inline constexpr double ball_mm = 1.0;

/// The nominal that the blade is `over_mm` larger than, all round and exactly: its parallel curve. The zones are
/// 2 half_zone_mm wide, the fit knows the form of the edges.
SectionSetup setup_of(const fitting::families::Blade& blade, double over_mm);

/// Where the planner has the blade measured, with about so many points; as fast as a part file says by default.
PlannedPath planned_lap(const SectionSetup& setup, std::size_t points);

/// Parameter of the outline's place that a ball on its way there touches.
double place_of(const fitting::families::Blade& blade, const drivers::PathPoint& point);

/// A swelling of the suction side with its top in the middle, as a share of its height; its width as a share of the
/// side.
double swelling(double t, double width);

std::vector<RecordedPoint> recorded(const std::vector<fitting::families::Vec2>& centres);

}  // namespace cmm::acquisition::decisions
