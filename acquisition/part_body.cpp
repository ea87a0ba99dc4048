// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_body.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "acquisition/part_rows.hpp"
#include "cad/spline_body.hpp"
#include "fitting/surface_fit.hpp"
#include "fitting/surface_index.hpp"

namespace cmm::acquisition {
namespace {

constexpr double triangle_deflection_mm = 5e-3;

/// A solid takes no section that has gaps; a surface has holes there.
bool takes(PartBody body, const SectionResult& section) {
    return section.has_contour() && (body == PartBody::surface || section.gaps().empty());
}

/// A section's gap reaches to the sections beside it; between two there is nothing where one lies that has no contour.
std::vector<cad::NetHole> holes_of(const PartResult& part, const std::vector<const SectionResult*>& upwards,
                                   const fitting::Surface& surface) {
    std::vector<cad::NetHole> holes;
    const fitting::SurfaceIndex index(surface);
    for (std::size_t k = 0; k < upwards.size(); ++k) {
        const SectionResult& section = *upwards[k];
        const double below = upwards[k > 0 ? k - 1 : 0]->z_mm;
        const double above = upwards[std::min(k + 1, upwards.size() - 1)]->z_mm;
        const auto place_of = [&](std::size_t point) {
            const Eigen::Vector2d& at = section.fit->contour[point].position_mm;
            return index.closest({at.x(), at.y(), section.z_mm}).place.u;
        };
        for (const ContourGap& gap : section.gaps())
            holes.push_back({place_of(gap.before), place_of(gap.behind), below, above});
        const bool lacks_one = std::any_of(part.sections.begin(), part.sections.end(), [&](const SectionResult& other) {
            return !other.has_contour() && other.z_mm > section.z_mm && other.z_mm < above;
        });
        if (lacks_one) holes.push_back({surface.u().front(), surface.u().back(), section.z_mm, above});
    }
    return holes;
}

core::Result<cad::SplineNet> net_of(const PartResult& part, PartBody body) {
    std::vector<const SectionResult*> upwards;
    for (const auto& section : part.sections)
        if (takes(body, section)) upwards.push_back(&section);
    if (upwards.size() < 2)
        return core::fail(core::ErrorCode::fit_not_evaluable,
                          std::string("a body needs two sections that ") +
                              (body == PartBody::solid ? "were measured all round" : "have a contour") + "; there " +
                              (upwards.empty() ? "is none" : "is one"));
    std::stable_sort(upwards.begin(), upwards.end(), [](auto* a, auto* b) { return a->z_mm < b->z_mm; });
    const auto rows = part_rows(upwards);
    if (!rows) return tl::unexpected(rows.error());
    const auto fit = fitting::fit_surface(*rows);
    if (!fit) return tl::unexpected(fit.error());
    const fitting::Surface& surface = fit->surface;
    cad::SplineNet net;
    net.knots_u = surface.u().knots();
    net.knots_v = surface.v().knots();
    net.closed_u = true;
    net.count_u = surface.u().controls();
    for (std::size_t j = 0; j < surface.v().controls(); ++j)
        for (std::size_t i = 0; i < net.count_u; ++i)
            net.controls.push_back(surface.control(i, j));
    if (body == PartBody::surface) net.holes = holes_of(part, upwards, surface);
    return net;
}

}  // namespace

std::vector<const SectionResult*> passed_over(const PartResult& part) {
    std::vector<const SectionResult*> sections;
    for (const auto& section : part.sections)
        if (!takes(PartBody::solid, section)) sections.push_back(&section);
    return sections;
}

core::Status export_step(const PartResult& part, PartBody body, const std::string& file) {
    const auto net = net_of(part, body);
    if (!net) return tl::unexpected(net.error());
    cad::StepOptions options;
    options.form = body == PartBody::solid ? cad::BodyForm::solid : cad::BodyForm::surface;
    options.name = part.part_serial.empty() ? part.part_name : part.part_name + " " + part.part_serial;
    const std::size_t missing = body == PartBody::solid ? passed_over(part).size() : 0;
    if (missing > 0)
        options.description = "passes over " + std::to_string(missing) + " of " + std::to_string(part.sections.size()) +
                              " sections, which were not measured all round";
    return cad::write_step(*net, options, file);
}

core::Status export_stl(const PartResult& part, const std::string& file) {
    const auto net = net_of(part, PartBody::solid);
    if (!net) return tl::unexpected(net.error());
    return cad::write_stl(*net, triangle_deflection_mm, file);
}

}  // namespace cmm::acquisition
