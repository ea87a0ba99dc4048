// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_start.hpp"

#include "fitting/live_spline.hpp"

namespace cmm::acquisition {
namespace {

std::optional<Eigen::Vector2d> last_contact(std::span<const RecordedPoint> measured) {
    for (auto point = measured.rbegin(); point != measured.rend(); ++point) {
        if (point->verdict.reason != fitting::RejectReason::no_contact) return point->centre_mm.head<2>();
    }
    return std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector2d> last_normal(std::span<const RecordedPoint> measured) {
    // An unknown section is scanned counter-clockwise: the material is on the left.
    fitting::LiveSpline curve(fitting::MaterialSide::left);
    for (std::size_t i = 0; i < measured.size(); ++i) {
        const bool no_contact = measured[i].verdict.reason == fitting::RejectReason::no_contact;
        curve.add(i, measured[i].centre_mm.head<2>(), no_contact);
    }
    const auto newest = curve.newest();
    if (!newest.valid) return std::nullopt;
    return newest.normal;
}

Eigen::Vector3d start_of_section(const Plan& plan, const PlannedPath& path, const SectionSetup& setup,
                                 std::span<const RecordedPoint> measured) {
    if (!path.points.empty()) {
        const std::size_t next = std::min(measured.size(), path.points.size() - 1);
        return above(path.points[next], plan.approach_mm);
    }
    const auto contact = last_contact(measured);
    const auto normal = last_normal(measured);
    if (contact && normal) {
        const Eigen::Vector2d start = *contact + plan.approach_mm * *normal;
        return {start.x(), start.y(), setup.z_mm};
    }
    return {path.start_mm->x(), path.start_mm->y(), setup.z_mm};
}

std::optional<Eigen::Vector2d> way_off(const SectionSetup& setup, std::span<const RecordedPoint> measured,
                                       const Eigen::Vector2d& probe_mm, double near_mm) {
    if (setup.nominal) {
        const auto& curve = setup.nominal->section.curve();
        const auto foot = curve.closest(probe_mm);
        if (foot.distance_mm > near_mm) return std::nullopt;
        return curve.evaluate(foot.s_mm).normal;
    }
    const auto contact = last_contact(measured);
    if (!contact || (*contact - probe_mm).norm() > near_mm) return std::nullopt;
    return last_normal(measured);
}

}  // namespace cmm::acquisition
