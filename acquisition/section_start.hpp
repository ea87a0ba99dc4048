// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "acquisition/plan.hpp"
#include "acquisition/section_setup.hpp"

/// Where a section is entered and left, also after a run that broke off in it. Part frame = machine frame, mm.
namespace cmm::acquisition {

/// Where free travel ends before the section is measured: above the next point of the plan, or, on an unknown part,
/// where the first touch starts (above the last point measured when the section is resumed).
Eigen::Vector3d start_of_section(const Plan& plan, const PlannedPath& path, const SectionSetup& setup,
                                 std::span<const RecordedPoint> measured);

/// The outward normal in the plane at the last measured point of an unknown section: from its live curve.
/// Nothing below three measured points.
std::optional<Eigen::Vector2d> last_normal(std::span<const RecordedPoint> measured);

/// The direction that leads away from the part, for a probe that stands within `near_mm` of it; nothing when it does
/// not.
std::optional<Eigen::Vector2d> way_off(const SectionSetup& setup, std::span<const RecordedPoint> measured,
                                       const Eigen::Vector2d& probe_mm, double near_mm);

}  // namespace cmm::acquisition
