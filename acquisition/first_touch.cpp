// SPDX-License-Identifier: Apache-2.0
#include "acquisition/first_touch.hpp"

#include <algorithm>
#include <cmath>

#include "fitting/vec2.hpp"

namespace cmm::acquisition {
namespace {

constexpr double line_spacing_mm = 5.0;  // a blade's chord is longer than that

using fitting::left_of;

Eigen::Vector3d at_height(const Eigen::Vector2d& p, double z_mm) {
    return {p.x(), p.y(), z_mm};
}

/// Where the ray from a point inside or outside the box leaves it for the last time; nothing when it misses the box.
std::optional<Eigen::Vector2d> far_side(const Eigen::Vector2d& from, const Eigen::Vector2d& direction,
                                        const std::array<double, 4>& box) {
    double enter = -1e9;
    double leave = 1e9;
    for (int axis = 0; axis < 2; ++axis) {
        const double low = box[static_cast<std::size_t>(axis)] - from[axis];
        const double high = box[static_cast<std::size_t>(axis) + 2] - from[axis];
        if (std::abs(direction[axis]) < 1e-12) {
            if (low > 0.0 || high < 0.0) return std::nullopt;
            continue;
        }
        enter = std::max(enter, std::min(low / direction[axis], high / direction[axis]));
        leave = std::min(leave, std::max(low / direction[axis], high / direction[axis]));
    }
    if (leave <= std::max(enter, 0.0)) return std::nullopt;
    return Eigen::Vector2d(from + leave * direction);
}

}  // namespace

void bound_by_travel(PartFile& part, const drivers::Capabilities& capabilities) {
    if (part.scan.box_mm) return;
    // The way round the box, and the ball's start outside it, must still be within the travel.
    const double room = 2.0 * (part.scan.clearance_mm + part.scan.approach_mm + part.stylus.radius_mm) + 1.0;
    const auto& low = capabilities.limit_min_mm;
    const auto& high = capabilities.limit_max_mm;
    part.scan.box_mm = std::array<double, 4>{low.x() + room, low.y() + room, high.x() - room, high.y() - room};
}

std::vector<TouchLine> touch_lines(const PlannedPath& path, const PartFile& part, const std::optional<Entry>& before) {
    std::vector<TouchLine> lines;
    if (before) {
        const Eigen::Vector2d contact = before->contact_mm.head<2>();
        const double far = 2.0 * part.scan.clearance_mm + part.scan.search_mm;
        lines.push_back({at_height(contact + far * before->outward, path.z_mm),
                         at_height(contact - far * before->outward, path.z_mm)});
    }
    const Eigen::Vector2d start = *path.start_mm;
    const Eigen::Vector2d direction = (*path.toward_mm - start).normalized();
    const auto& box = *part.scan.box_mm;
    const double widest = std::hypot(box[2] - box[0], box[3] - box[1]);
    for (int k = 0; k * line_spacing_mm <= widest; ++k) {
        for (const double sign : {1.0, -1.0}) {
            if (k == 0 && sign < 0.0) continue;
            const Eigen::Vector2d from = start + sign * k * line_spacing_mm * left_of(direction);
            const auto to = far_side(from, direction, box);
            if (to) lines.push_back({at_height(from, path.z_mm), at_height(*to, path.z_mm)});
        }
    }
    return lines;
}

Eigen::Vector2d outward_normal(const Eigen::Vector2d& first, std::span<const Eigen::Vector2d> beside,
                               const Eigen::Vector2d& direction) {
    const Eigen::Vector2d along = left_of(direction);
    double slope = 0.0;
    int used = 0;
    for (const auto& contact : beside) {
        const double aside = (contact - first).dot(along);
        if (std::abs(aside) < 1e-3) continue;
        // Steeper than 70 degrees is over an edge, not along the surface.
        const double rise = (contact - first).dot(direction) / aside;
        if (std::abs(rise) > 2.75) continue;
        slope += rise;
        ++used;
    }
    if (used > 0) slope /= used;
    // The surface runs along (along + slope * direction); its normal points against the touch.
    return (slope * along - direction).normalized();
}

Entry entry_of(std::span<const Eigen::Vector3d> measured) {
    Entry entry;
    entry.contact_mm = measured.front();
    const std::size_t ahead = std::min<std::size_t>(3, measured.size() - 1);
    const Eigen::Vector2d travel = (measured[ahead] - measured.front()).head<2>();
    if (travel.norm() > 0.0) entry.outward = -left_of(travel.normalized());
    return entry;
}

}  // namespace cmm::acquisition
