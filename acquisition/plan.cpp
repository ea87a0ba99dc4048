// SPDX-License-Identifier: Apache-2.0
#include "acquisition/plan.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double unknown_machine_travel_mm_s = 50.0;

core::Result<PlannedPath> plan_section(const PartFile& part, const NominalContour& cut, std::size_t index,
                                       double largest_speed) {
    const auto section = fitting::analyse_nominal(cut.points, edge_hints(part.nominal, cut));
    if (!section) {
        return core::fail(core::ErrorCode::input_invalid, "the nominal at z = " + core::fixed(cut.z_mm, 3) +
                                                              " mm is no section: " + section.error().text());
    }
    const double radius = part.stylus.radius_mm;
    auto ball = ball_path(section->curve(), radius);
    if (ball.points.size() < 8) {
        return core::fail(core::ErrorCode::plan_invalid,
                          "the ball finds no way round the nominal at z = " + core::fixed(cut.z_mm, 3) + " mm");
    }
    SamplingOptions sampling;
    sampling.pitch_mm = part.scan.pitch_mm;
    sampling.edge_density = part.scan.edge_density;
    PlannedPath path;
    path.section = index;
    path.z_mm = cut.z_mm;
    path.unreached = std::move(ball.unreached);
    for (const auto& point : sample_ball_path(ball, *section, radius, sampling)) {
        drivers::PathPoint planned;
        planned.centre_mm = {point.centre_mm.x(), point.centre_mm.y(), cut.z_mm};
        planned.normal = {point.normal.x(), point.normal.y(), 0.0};
        planned.speed_mm_s = scanning_speed_mm_s(point.step_mm, part.scan.pitch_mm, largest_speed);
        if (!path.points.empty()) {
            const double step = (planned.centre_mm - path.points.back().centre_mm).norm();
            path.length_mm += step;
            path.duration_s += step / planned.speed_mm_s;
        }
        path.points.push_back(planned);
    }
    return path;
}

/// Without a nominal: from outside the box towards its middle, across its longer side, where a blade is broad.
void plan_first_touch(PlannedPath& path, const PartFile& part, const Clearance& clearance) {
    const auto& box = part.scan.box_mm.value();
    const Vector2d low(box[0], box[1]), high(box[2], box[3]), middle = 0.5 * (low + high);
    const bool wide = high.x() - low.x() >= high.y() - low.y();
    const Vector2d outside =
        wide ? Vector2d(middle.x(), clearance.low_mm.y()) : Vector2d(clearance.low_mm.x(), middle.y());
    path.start_mm = part.scan.start_mm.value_or(outside);
    path.toward_mm = part.scan.toward_mm.value_or(middle);
}

void plan_travel(Plan& plan) {
    double travel = 0.0;
    for (std::size_t k = 0; k < plan.paths.size(); ++k) {
        auto& path = plan.paths[k];
        if (path.points.empty()) continue;
        const Vector3d to = above(path.points.front(), plan.approach_mm);
        // Where the probe stands before the first section is not known: from beside the box at its height.
        const Vector3d from = k == 0 ? Vector3d(plan.clearance.low_mm.x(), plan.clearance.low_mm.y(), path.z_mm)
                                     : above(plan.paths[k - 1].points.back(), plan.approach_mm);
        path.approach_route = plan.clearance.route(from, to);
        Vector3d before = from;
        for (const auto& point : path.approach_route) {
            travel += (point - before).norm();
            before = point;
        }
        plan.duration_s += 2.0 * plan.approach_mm / plan.approach_speed_mm_s;
    }
    plan.duration_s += travel / plan.travel_speed_mm_s;
}

/// One cut a height; none without a nominal.
core::Result<std::vector<NominalContour>> cut_at_heights(const PartFile& part, const Nominal* nominal) {
    std::vector<NominalContour> cuts;
    for (const double z : part.scan.heights_mm) {
        if (nominal == nullptr) break;
        auto cut = nominal->cut(z);
        if (!cut) return tl::unexpected(std::move(cut.error()));
        cuts.push_back(std::move(*cut));
    }
    return cuts;
}

}  // namespace

double scanning_speed_mm_s(double step_mm, double pitch_mm, double largest_mm_s) {
    constexpr double slowest_share = 0.1;
    return largest_mm_s * std::clamp(step_mm / pitch_mm, slowest_share, 1.0);
}

Vector3d above(const drivers::PathPoint& point, double distance_mm) {
    return point.centre_mm + distance_mm * point.normal;
}

std::vector<Vector3d> travel_route(const Plan& plan, const Vector3d& from, const Vector3d& to) {
    return plan.clearance.route(from, to);
}

core::Result<Plan> make_plan(const PartFile& part, const Nominal* nominal, const drivers::Capabilities* capabilities) {
    if (nominal == nullptr && !part.scan.box_mm) {
        return core::fail(
            core::ErrorCode::plan_invalid,
            part.path + ": without a nominal and without [scan] box_mm the machine's travel must be known (--machine)");
    }
    Plan plan;
    plan.part_name = part.name;
    plan.approach_mm = part.scan.approach_mm;
    plan.search_mm = part.scan.search_mm;
    const bool known = capabilities != nullptr && capabilities->max_speed_mm_s > 0.0;
    plan.travel_speed_mm_s = known ? capabilities->max_speed_mm_s : unknown_machine_travel_mm_s;
    const double largest =
        known ? std::min(part.scan.max_speed_mm_s, capabilities->max_speed_mm_s) : part.scan.max_speed_mm_s;
    plan.approach_speed_mm_s = std::min(largest, 10.0);
    if (part.alignment.six_points && nominal != nullptr) {
        const auto points = on_nominal(*part.alignment.six_points, *nominal);
        if (!points) return tl::unexpected(points.error());
        plan.datum_middles = middles_of(*points);
        plan.datum_touches = datum_touches(*points, part.stylus.radius_mm, plan.approach_speed_mm_s);
        plan.datum_approach_mm = part.alignment.six_points->approach_mm;
        plan.datum_search_mm = part.alignment.six_points->search_mm;
    }
    const auto cut = cut_at_heights(part, nominal);
    if (!cut) return tl::unexpected(cut.error());
    const auto& cuts = *cut;
    plan.clearance = make_clearance(part, nominal, cuts);
    for (std::size_t k = 0; k < part.scan.heights_mm.size(); ++k) {
        PlannedPath path;
        path.section = k;
        path.z_mm = part.scan.heights_mm[k];
        if (nominal == nullptr) {
            plan_first_touch(path, part, plan.clearance);
        } else {
            auto planned = plan_section(part, cuts[k], k, largest);
            if (!planned) return tl::unexpected(std::move(planned.error()));
            path = std::move(*planned);
        }
        plan.length_mm += path.length_mm;
        plan.duration_s += path.duration_s;
        plan.paths.push_back(std::move(path));
    }
    if (nominal == nullptr)
        plan.clearance.way_out = (*plan.paths.front().start_mm - *plan.paths.front().toward_mm).normalized();
    plan_travel(plan);
    plan.hash = plan_hash(plan);
    return plan;
}

}  // namespace cmm::acquisition
