// SPDX-License-Identifier: Apache-2.0
#include "acquisition/surface_deviation.hpp"

#include <cmath>

#include "acquisition/nominal.hpp"

namespace cmm::acquisition {
namespace {

constexpr double slack_mm = 1e-6;  // the nearest place of the surface is no farther away than that of its cut

}  // namespace

std::vector<std::optional<double>> surface_deviations(const SectionResult& section) {
    if (!section.nominal_surface || !section.has_contour() ||
        section.deviation_mm.size() != section.fit->contour.size())
        return {};
    const auto& contour = section.fit->contour;
    const fitting::PlaneMotion& motion = section.alignment.motion;
    std::vector<std::optional<double>> deviations(contour.size());
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const auto& in_plane = section.deviation_mm[i];
        if (!in_plane) continue;
        const Eigen::Vector2d place = motion.undo(contour[i].position_mm);
        const Eigen::Vector2d outward = motion.undo_on_direction(contour[i].normal);
        const Eigen::Vector3d point(place.x(), place.y(), section.z_mm);
        const auto foot = section.nominal_surface->closest(point, place - *in_plane * outward);
        if (!foot) continue;
        const double along = (point - foot->position_mm).dot(foot->normal);
        if (std::abs(along) > std::abs(*in_plane) + slack_mm) continue;
        deviations[i] = foot->normal.head<2>().dot(outward) < 0.0 ? -along : along;
    }
    return deviations;
}

}  // namespace cmm::acquisition
