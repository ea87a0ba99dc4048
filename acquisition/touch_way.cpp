// SPDX-License-Identifier: Apache-2.0
#include "acquisition/touch_way.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "drivers/refusal.hpp"

namespace cmm::acquisition {
namespace {

// Of a circle of ball radius and distance such a chord cuts off 3.4 %: 0.07 mm of 2 mm.
constexpr double largest_turn_rad = 0.5236;

// What a controller that latches in its servo cycle of 1 ms can take: 2 um (docs/linuxcnc.md).
constexpr double fastest_touch_mm_s = 2.0;

double beside_mm(const drivers::PathPoint& place, const Eigen::Vector3d& contact_mm) {
    return (contact_mm - place.centre_mm).cross(place.normal).norm();
}

}  // namespace

core::Result<bool> measures_by_touches(const drivers::Capabilities& machine, bool asked) {
    const bool recorded = !machine.recorded_plan.empty();
    if (!machine.moves || recorded) {
        if (!asked) return false;
        return drivers::refuse(recorded ? "a recording is played as it was measured: leave --touch out"
                                        : "a person moves this machine: leave --touch out");
    }
    if (!asked && machine.scans_paths) return false;
    if (machine.touches) return true;
    return drivers::refuse(
        machine.scans_paths
            ? "this machine scans along paths but cannot take single touches: leave --touch out"
            : "this machine can neither scan along a path nor take single touches; `cmmlive doctor` shows "
              "what it says of itself");
}

double touch_speed_mm_s(const Plan& plan) {
    return std::min(fastest_touch_mm_s, plan.approach_speed_mm_s);
}

std::vector<Eigen::Vector3d> way_between(const drivers::PathPoint& from, const drivers::PathPoint& to,
                                         double distance_mm) {
    const Eigen::Vector3d axis = from.normal.cross(to.normal);
    const double turn = std::atan2(axis.norm(), from.normal.dot(to.normal));
    const auto steps = static_cast<std::size_t>(std::max(1.0, std::ceil(turn / largest_turn_rad)));
    std::vector<Eigen::Vector3d> way;
    for (std::size_t i = 1; i < steps; ++i) {
        const double share = static_cast<double>(i) / static_cast<double>(steps);
        // Opposite normals leave the side open; a section is gone round counter-clockwise.
        const Eigen::Vector3d about =
            axis.norm() > 1e-9 ? axis.normalized() : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
        const Eigen::Vector3d normal = Eigen::AngleAxisd(share * turn, about) * from.normal;
        way.emplace_back((1.0 - share) * from.centre_mm + share * to.centre_mm + distance_mm * normal);
    }
    way.emplace_back(to.centre_mm + distance_mm * to.normal);
    return way;
}

std::optional<std::size_t> blocked_place(std::span<const drivers::PathPoint> places,
                                         const fitting::ClosedCurve& outline, double ball_radius_mm,
                                         double distance_mm) {
    const double wanted_mm = ball_radius_mm + 0.5 * distance_mm;
    for (std::size_t i = 0; i < places.size(); ++i) {
        const auto way = way_between(places[i == 0 ? 0 : i - 1], places[i], distance_mm);
        const bool free = std::all_of(way.begin(), way.end(), [&](const Eigen::Vector3d& point) {
            return outline.closest(point.head<2>()).distance_mm >= wanted_mm;
        });
        if (!free) return i;
    }
    return std::nullopt;
}

std::size_t next_place(std::span<const drivers::PathPoint> places, std::span<const RecordedPoint> touched) {
    std::size_t next = 0;
    for (const auto& point : touched) {
        const std::size_t end = std::min(places.size(), next + most_missed_places + 1);
        if (next >= end) return places.size();
        const auto nearest = std::min_element(places.begin() + static_cast<std::ptrdiff_t>(next),
                                              places.begin() + static_cast<std::ptrdiff_t>(end),
                                              [&](const drivers::PathPoint& a, const drivers::PathPoint& b) {
                                                  return beside_mm(a, point.centre_mm) < beside_mm(b, point.centre_mm);
                                              });
        next = static_cast<std::size_t>(nearest - places.begin()) + 1;
    }
    return next;
}

}  // namespace cmm::acquisition
