// SPDX-License-Identifier: Apache-2.0
#include "fitting/contact_section.hpp"

#include <algorithm>
#include <utility>

#include "fitting/centre_curve.hpp"
#include "fitting/closest_point.hpp"
#include "fitting/contour.hpp"

namespace cmm::fitting {
namespace {

/// What the contacts know of the lean, along the curve through them.
std::vector<SurfaceStation> stations_along(const PiecewiseCubic& curve, std::span<const Contact> contacts,
                                           std::span<const Vec2> places) {
    std::vector<SurfaceStation> stations(contacts.size());
    const ClosestPointIndex index(curve);
    index.for_each(places, [&](std::size_t i, const CurveFoot& foot) {
        stations[i].t = curve.wrap(foot.t);
        stations[i].lean_rad = contacts[i].lean_rad;
        stations[i].lean_doubt_mm = contacts[i].bound_mm;
    });
    std::sort(stations.begin(), stations.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
    return stations;
}

}  // namespace

std::vector<Vec2> slid_into_plane(std::span<const Contact> contacts, double z_mm) {
    std::vector<Vec2> places;
    for (const Contact& contact : contacts) {
        const Vec3& n = contact.normal;
        const double level = n.head<2>().squaredNorm();
        const double rise = level > 0.0 ? (z_mm - contact.position_mm.z()) / level : 0.0;
        places.push_back(contact.position_mm.head<2>() - rise * n.z() * n.head<2>());
    }
    return places;
}

core::Result<ContactSection> section_of_contacts(std::span<const Contact> contacts, double z_mm, bool leans,
                                                 const SectionFit& flat, const SectionOptions& options) {
    const std::vector<Vec2> places = slid_into_plane(contacts, z_mm);
    SectionOptions own = options;
    own.ball_radius_mm = 0.0;
    own.lean_rad = 0.0;
    own.le_hint = flat.le_point_mm;
    own.te_hint = flat.te_point_mm;
    auto curve = fit_centre_curve(places, {}, own);
    if (!curve) return tl::unexpected(curve.error());
    ContactSection result;
    result.set_aside = curve->rejected;
    result.fit.missing = flat.missing;
    result.fit.verdicts = flat.verdicts;
    result.fit.rejected = flat.rejected;
    result.fit.noise_sigma_mm = curve->of_contour().sigma_mm;
    std::vector<SurfaceStation> stations;
    if (leans) stations = stations_along(curve->of_contour().curve, contacts, places);
    const auto open = build_contour(curve->of_contour(), curve->good, own, result.fit, stations);
    if (!open) return tl::unexpected(open.error());
    fit_open_edges(*open, curve->of_contour(), curve->good, result.fit);
    result.fit.centres = flat.centres;
    return result;
}

}  // namespace cmm::fitting
