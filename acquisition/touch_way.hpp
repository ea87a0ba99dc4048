// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "acquisition/plan.hpp"
#include "acquisition/section_result.hpp"
#include "drivers/machine.hpp"
#include "fitting/closed_curve.hpp"

/// The geometry of a section that is measured by single touches: its places are path points, each touched along its
/// normal from a distance. Part frame = machine frame, mm.
namespace cmm::acquisition {

/// So many places of a plan in a row may be without contact; one more ends the section.
inline constexpr std::size_t most_missed_places = 5;

/// Whether a machine measures sections by single touches: asked to, or since it cannot scan along a path. A recording
/// is played as a scan whatever it was, and where a person moves the machine nothing touches. Errors: machine_refused
/// (it can do neither, or not what was asked for).
core::Result<bool> measures_by_touches(const drivers::Capabilities& machine, bool asked);

/// Speed of a touch, mm/s.
double touch_speed_mm_s(const Plan& plan);

/// Way points from above `from` to above `to`, the last of them: straight where the normals agree, round an edge in
/// steps of at most 30 degrees, so that the straight way between two of them stays off the part.
std::vector<Eigen::Vector3d> way_between(const drivers::PathPoint& from, const drivers::PathPoint& to,
                                         double distance_mm);

/// The first place whose way from the one before comes nearer to the outline than ball radius and half the distance:
/// the bottom of a hollow that is too narrow for it. Nothing: the ways are free.
std::optional<std::size_t> blocked_place(std::span<const drivers::PathPoint> places,
                                         const fitting::ClosedCurve& outline, double ball_radius_mm,
                                         double distance_mm);

/// The place that comes after those that were touched: every contact lies on the line of approach of its place, and up
/// to most_missed_places between two of them were without contact. `places.size()`: none is left.
std::size_t next_place(std::span<const drivers::PathPoint> places, std::span<const RecordedPoint> touched);

}  // namespace cmm::acquisition
