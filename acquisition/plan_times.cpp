// SPDX-License-Identifier: Apache-2.0
#include "acquisition/plan_times.hpp"

#include <algorithm>

#include "acquisition/touch_way.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector3d;

constexpr double draw_back_mm_s = 5.0;  // of LinuxCNC's driver
// What starting, stopping and the next command add to a short way: 0.28 s of 30 mm at 1.5 m/s^2.
constexpr double start_and_stop_s = 0.25;

/// Down onto the part and back.
double touch_s(const Plan& plan, double from_mm) {
    return from_mm / touch_speed_mm_s(plan) + from_mm / draw_back_mm_s;
}

double length_of(Vector3d at, const std::vector<Vector3d>& way) {
    double length = 0.0;
    for (const auto& point : way) {
        length += (point - at).norm();
        at = point;
    }
    return length;
}

/// The ways from above the first datum point round all of them and back to it, `approach_mm` above.
double datum_ways_s(const Plan& plan, double approach_mm) {
    double seconds = 0.0;
    const auto& touches = plan.datum_touches;
    for (std::size_t i = 0; i < touches.size(); ++i) {
        const Vector3d from = above(touches[i], approach_mm),
                       to = above(touches[(i + 1) % touches.size()], approach_mm);
        const auto way = travel_route(plan, from, to);
        seconds += length_of(from, way) / plan.travel_speed_mm_s + start_and_stop_s * static_cast<double>(way.size());
    }
    return seconds;
}

double alignment_s(const Plan& plan) {
    if (plan.datum_touches.empty()) return 0.0;
    const auto touches = static_cast<double>(plan.datum_touches.size());
    const auto round_s = [&](double from_mm) { return datum_ways_s(plan, from_mm) + touches * touch_s(plan, from_mm); };
    return round_s(plan.datum_approach_mm) +
           (usual_datum_rounds - 1) * round_s(std::min(plan.datum_approach_mm, plan.approach_mm));
}

double touched_s(const Plan& plan, const PlannedPath& path) {
    double way_mm = 0.0;
    for (std::size_t i = 1; i < path.points.size(); ++i)
        way_mm += length_of(above(path.points[i - 1], plan.approach_mm),
                            way_between(path.points[i - 1], path.points[i], plan.approach_mm));
    return way_mm / plan.approach_speed_mm_s +
           static_cast<double>(path.points.size()) * touch_s(plan, plan.approach_mm);
}

}  // namespace

PlanTimes plan_times(const Plan& plan, bool by_touches) {
    PlanTimes times;
    times.alignment_s = alignment_s(plan);
    times.total_s = times.alignment_s + plan.duration_s;
    for (const auto& path : plan.paths) {
        times.sections_s.push_back(by_touches ? touched_s(plan, path) : path.duration_s);
        times.total_s += times.sections_s.back() - path.duration_s;
    }
    return times;
}

}  // namespace cmm::acquisition
