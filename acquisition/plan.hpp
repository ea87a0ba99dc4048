// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/ball_path.hpp"
#include "acquisition/clearance.hpp"
#include "acquisition/datum_touches.hpp"
#include "acquisition/nominal.hpp"
#include "acquisition/part_file.hpp"
#include "drivers/machine.hpp"

namespace cmm::acquisition {

/// One section of a plan. Without a nominal it has no points, only where the first touch starts and where it goes.
struct PlannedPath {
    std::size_t section = 0;
    double z_mm = 0.0;
    std::vector<drivers::PathPoint> points;  ///< ball centres, counter-clockwise, past the start; all recorded
    std::vector<Eigen::Vector3d>
        approach_route;  ///< way points from the end of the path before to above the first point
    std::optional<Eigen::Vector2d> start_mm, toward_mm;  ///< without a nominal
    std::vector<UnreachedPlace> unreached;               ///< concave places that the ball bridges
    double length_mm = 0.0;
    double duration_s = 0.0;  ///< of the scan, without travel
};

/// What will be driven: a value with a file form (JSON) and a hash of it. Millimetres, part frame = machine frame.
struct Plan {
    static constexpr int schema_version = 1;
    std::string part_name;
    double approach_mm = 1.0, search_mm = 1.0;
    double travel_speed_mm_s = 50.0, approach_speed_mm_s = 5.0;
    Clearance clearance;
    /// Before the first section: the ball's places on the six datum points, none without such an alignment.
    std::vector<drivers::PathPoint> datum_touches;
    DatumMiddles datum_middles{};
    double datum_approach_mm = 0.0, datum_search_mm = 0.0;  ///< above and below them
    std::vector<PlannedPath> paths;                         ///< one a section, ascending
    double length_mm = 0.0;                                 ///< scanned
    double duration_s = 0.0;                                ///< scans and travel, estimate (plan_times has all of it)
    std::string hash;                                       ///< of everything above
};

/// The speed follows the step, which goes with the square root of the radius of curvature, so the centripetal
/// acceleration stays the same all round: `largest_mm_s` at the pitch, a tenth of it at the sharpest edge.
double scanning_speed_mm_s(double step_mm, double pitch_mm, double largest_mm_s);

/// Errors: plan_invalid (a height outside the nominal), input_invalid (a cut that is no section).
/// `capabilities` (nullptr: not known yet) bounds the speeds.
core::Result<Plan> make_plan(const PartFile& part, const Nominal* nominal,
                             const drivers::Capabilities* capabilities = nullptr);

/// Way points of a free travel after `from` up to and with `to`; empty: there is none (plan_check says so beforehand).
std::vector<Eigen::Vector3d> travel_route(const Plan& plan, const Eigen::Vector3d& from, const Eigen::Vector3d& to);
/// Where a scan that begins at this point starts its touch-down, and where one that ended there stands after the
/// retract.
Eigen::Vector3d above(const drivers::PathPoint& point, double distance_mm);

/// The file form. `plan.hash` is the hash of this text without its hash.
std::string plan_to_text(const Plan& plan);
/// Errors: config_syntax, config_invalid (schema, missing values, a hash that does not fit).
core::Result<Plan> parse_plan(std::string_view text, const std::string& name);
std::string plan_hash(const Plan& plan);

}  // namespace cmm::acquisition
