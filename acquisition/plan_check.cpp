// SPDX-License-Identifier: Apache-2.0
#include "acquisition/plan_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "acquisition/datum_touches.hpp"
#include "acquisition/plan_times.hpp"
#include "acquisition/section_setup.hpp"
#include "acquisition/touch_way.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector3d;

std::string at_section(const PlannedPath& path) {
    return section_text(path.section, path.z_mm) + ": ";
}

std::string point_text(const Eigen::Vector2d& p) {
    return "x " + core::fixed(p.x(), 3) + ", y " + core::fixed(p.y(), 3) + " mm";
}

class PlanCheck {
  public:
    PlanCheck(const Plan& plan, const PartFile& part) : plan_(plan), part_(part) {}

    void limits(const drivers::Capabilities& machine) {
        for (const auto& path : plan_.paths) {
            std::vector<Vector3d> visited = path.approach_route;
            for (const auto& point : path.points) {
                visited.push_back(point.centre_mm);
                visited.push_back(above(point, std::max(plan_.approach_mm, plan_.search_mm)));
            }
            for (const auto& end : {path.start_mm, path.toward_mm}) {
                if (end) visited.emplace_back(end->x(), end->y(), path.z_mm);
            }
            for (const auto& p : visited) {
                if (!within(p, machine, at_section(path))) break;  // one finding a section is enough
            }
        }
    }

    /// The six datum points, where the part is expected: within the travel, with a free way there and room above.
    void datums(const drivers::Capabilities* machine) {
        if (!plan_.datum_touches.empty()) {
            const auto hold =
                fitting::hold_of(points_touched(plan_.datum_touches, plan_.datum_middles, part_.stylus.radius_mm));
            const auto middles = std::count(plan_.datum_middles.begin(), plan_.datum_middles.end(), true);
            add(Severity::note, "six datum points" +
                                    (middles > 0 ? " (" + std::to_string(middles) + " of them middles of two touches)"
                                                 : std::string()) +
                                    ", touched before the first section; condition number " +
                                    core::fixed(hold.condition, 1) + ", lengths in units of " +
                                    core::fixed(hold.length_mm, 1) + " mm");
        }
        for (std::size_t i = 0; i < plan_.datum_touches.size(); ++i) {
            const std::string where = datum_touch_name(plan_.datum_middles, i) + ": ";
            const auto& touch = plan_.datum_touches[i];
            const Vector3d start = above(touch, plan_.datum_approach_mm);
            if (machine != nullptr)
                within(start, *machine, where) && within(above(touch, -plan_.datum_search_mm), *machine, where);
            if (travel_route(plan_, plan_.clearance.high_corner_mm(), start).empty() ||
                plan_.clearance.gap_mm(start) <= 0.0)
                add(Severity::error, where + "no free way for the stylus to " + point_text(start.head<2>()) +
                                         ", where its touch begins");
        }
    }

    void travel() {
        for (const auto& path : plan_.paths) {
            if (path.points.empty()) continue;
            if (path.approach_route.empty()) {
                add(Severity::error, at_section(path) + "no free way for the stylus to its first point");
                continue;
            }
            for (std::size_t i = 0; i + 1 < path.approach_route.size(); ++i)
                leg(path, path.approach_route[i], path.approach_route[i + 1]);
        }
    }

    void shank() {
        const auto& stylus = plan_.clearance.stylus;
        for (const auto& path : plan_.paths) {
            double worst = 0.0, height = 0.0;
            for (const auto& obstacle : plan_.clearance.obstacles) {
                const double rise = obstacle.z_mm - path.z_mm;
                if (rise <= stylus.radius_mm || rise > stylus.length_mm) continue;
                if (deepen(worst, path, obstacle, stylus.shank_radius_mm)) height = obstacle.z_mm;
            }
            if (worst <= 0.0) continue;
            const double angle = std::atan2(worst, height - path.z_mm) * 180.0 / std::acos(-1.0);
            add(Severity::warning, at_section(path) + "a shank that hangs straight down would enter the part by " +
                                       core::length_text(worst) + " at z " + core::fixed(height, 3) +
                                       " mm; incline the stylus by " + core::fixed(std::ceil(angle), 0) +
                                       " degrees or more, or use a longer, thinner one");
        }
    }

    void concave_places() {
        for (const auto& path : plan_.paths) {
            for (const auto& place : path.unreached) {
                add(Severity::warning, at_section(path) + "the ball (radius " + core::fixed(part_.stylus.radius_mm, 3) +
                                           " mm) does not fit the concave place at " + point_text(place.position_mm) +
                                           "; it is bridged, " + core::length_text(place.depth_mm) + " deep");
            }
        }
    }

    void clock(const drivers::Capabilities& machine) {
        if (machine.sample_rate_hz <= 0.0) return;
        double shortest_s = std::numeric_limits<double>::max();
        for (const auto& path : plan_.paths) {
            for (std::size_t i = 1; i < path.points.size(); ++i) {
                const double step = (path.points[i].centre_mm - path.points[i - 1].centre_mm).norm();
                shortest_s = std::min(shortest_s, step / path.points[i].speed_mm_s);
            }
        }
        if (shortest_s * machine.sample_rate_hz < 1.0) {
            add(Severity::warning, "the points come faster than the machine's sample clock (" +
                                       core::fixed(machine.sample_rate_hz, 0) + " Hz); the machine will slow down");
        }
    }

    void recording(const drivers::Capabilities& machine) {
        if (machine.recorded_plan.empty() || machine.recorded_plan == plan_.hash) return;
        add(Severity::error, "the recording was made by another plan (" + machine.recorded_plan + ", this one is " +
                                 plan_.hash + "): take the part file of that run, `cmmlive fit` judges by another one");
    }

    void by_hand() {
        add(Severity::note, "a person moves this machine: " + std::to_string(plan_.paths.size()) +
                                " sections at their heights, no path is driven");
    }

    void touch_ways(const Nominal& nominal) {
        for (const auto& path : plan_.paths) {
            const auto setup = make_section_setup(part_, &nominal, path.section, path.z_mm);
            if (!setup || !setup->nominal) continue;
            const auto blocked =
                blocked_place(path.points, setup->nominal->section.curve(), part_.stylus.radius_mm, plan_.approach_mm);
            if (!blocked) continue;
            add(Severity::error, at_section(path) + "the way to the touch at " +
                                     point_text(path.points[*blocked].centre_mm.head<2>()) +
                                     " leads too close to the part; a smaller [scan] approach_mm helps in a hollow");
        }
    }

    void duration(bool by_touches) {
        std::size_t points = 0;
        for (const auto& path : plan_.paths)
            points += path.points.size();
        if (points == 0) return;
        add(Severity::note, std::to_string(plan_.paths.size()) + " sections, " + std::to_string(points) + " points, " +
                                (by_touches ? "one by one" : core::fixed(plan_.length_mm, 1) + " mm of scan") +
                                ", about " + core::fixed(plan_times(plan_, by_touches).total_s, 0) + " s");
    }

    std::vector<Finding> findings;

  private:
    void add(Severity severity, std::string text) { findings.push_back({severity, std::move(text)}); }

    /// Raises `depth` to the deepest that a shank on this path enters the outline. Depth changes by no more than the
    /// shank moves, so that points which cannot be the deepest need no look.
    static bool deepen(double& depth, const PlannedPath& path, const Obstacle& obstacle, double shank_radius_mm) {
        bool deeper = false;
        double harmless_mm = 0.0;
        for (std::size_t i = 0; i < path.points.size(); ++i) {
            const Eigen::Vector2d at = path.points[i].centre_mm.head<2>();
            if (i > 0) harmless_mm -= (at - path.points[i - 1].centre_mm.head<2>()).norm();
            if (harmless_mm > 0.0) continue;
            const double here = shank_radius_mm - distance_to_outline(at, obstacle.outline);
            deeper = deeper || here > depth;
            depth = std::max(depth, here);
            harmless_mm = depth - here;
        }
        return deeper;
    }

    bool within(const Vector3d& p, const drivers::Capabilities& machine, const std::string& where) {
        for (Eigen::Index k = 0; k < 3; ++k) {
            if (p[k] >= machine.limit_min_mm[k] && p[k] <= machine.limit_max_mm[k]) continue;
            const std::string axis(1, "xyz"[k]);
            add(Severity::error, where + axis + " = " + core::fixed(p[k], 3) +
                                     " mm lies outside the machine's travel (" +
                                     core::fixed(machine.limit_min_mm[k], 3) + " mm to " +
                                     core::fixed(machine.limit_max_mm[k], 3) + " mm)");
            return false;
        }
        return true;
    }

    /// A straight travel between two way points. Its last stretch down to the start of the scan may come as near as the
    /// start is.
    void leg(const PlannedPath& path, const Vector3d& from, const Vector3d& to) {
        const double length = (to - from).norm();
        const auto steps = static_cast<int>(std::ceil(length / 0.5));
        for (int k = 1; k < steps; ++k) {
            const Vector3d p = from + (to - from) * (static_cast<double>(k) / steps);
            // Only the ball and the plane it travels in: what the shank meets above is the other check's.
            for (const auto& obstacle : plan_.clearance.obstacles) {
                if (std::abs(obstacle.z_mm - p.z()) > part_.stylus.radius_mm) continue;
                if (distance_to_outline(p.head<2>(), obstacle.outline) > part_.stylus.radius_mm) continue;
                add(Severity::error,
                    at_section(path) + "the travel to its first point cuts the part at " + point_text(p.head<2>()));
                return;
            }
        }
    }

    const Plan& plan_;
    const PartFile& part_;
};

}  // namespace

std::string_view to_string(Severity severity) noexcept {
    return severity == Severity::error ? "error" : severity == Severity::warning ? "warning" : "note";
}

std::vector<Finding> check_plan(const Plan& plan, const PartFile& part, const Nominal* nominal,
                                const drivers::Capabilities* capabilities, bool by_touches) {
    PlanCheck check(plan, part);
    if (capabilities != nullptr && !capabilities->moves) {
        check.recording(*capabilities);
        check.by_hand();
        return std::move(check.findings);
    }
    if (capabilities != nullptr) {
        check.recording(*capabilities);
        check.limits(*capabilities);
        if (!by_touches) check.clock(*capabilities);
    }
    if (nominal != nullptr) {
        check.datums(capabilities);
        if (by_touches) check.touch_ways(*nominal);
        check.travel();
        check.shank();
        check.concave_places();
    }
    check.duration(by_touches);
    std::stable_sort(check.findings.begin(), check.findings.end(),
                     [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
    return std::move(check.findings);
}

core::Status require_sound(const std::vector<Finding>& findings) {
    std::string text;
    for (const auto& finding : findings) {
        if (finding.severity == Severity::error) text += (text.empty() ? "" : "; ") + finding.text;
    }
    if (text.empty()) return {};
    return core::fail(core::ErrorCode::plan_invalid, std::move(text), core::Motion::stopped);
}

}  // namespace cmm::acquisition
