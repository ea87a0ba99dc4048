// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_body.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "acquisition/part_rows.hpp"
#include "cad/spline_body.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
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
                                   const fitting::Surface& surface, const fitting::SurfaceIndex& index) {
    std::vector<cad::NetHole> holes;
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

void measure_off(const std::vector<const SectionResult*>& sections, const fitting::SurfaceIndex& index,
                 WrittenBody& body) {
    double squares = 0.0, most = -1.0;
    std::size_t count = 0;
    for (const SectionResult* section : sections) {
        std::vector<fitting::Vec3> points;
        for (const auto& point : section->fit->contour)
            if (point.measured) points.emplace_back(point.position_mm.x(), point.position_mm.y(), section->z_mm);
        std::vector<fitting::SurfaceFoot> feet(points.size());
        index.closest(points, feet);
        count += feet.size();
        for (const auto& foot : feet) {
            squares += foot.squared;
            if (foot.squared <= most) continue;
            most = foot.squared;
            body.farthest = section;
        }
    }
    if (count == 0) return;
    body.off_rms_mm = std::sqrt(squares / static_cast<double>(count));
    body.off_max_mm = std::sqrt(most);
}

struct Body {
    cad::SplineNet net;
    WrittenBody written;
};

core::Result<Body> body_of(const PartResult& part, PartBody kind) {
    Body body;
    std::vector<const SectionResult*> upwards;
    for (const auto& section : part.sections)
        (takes(kind, section) ? upwards : body.written.passed_over).push_back(&section);
    if (upwards.size() < 2)
        return core::fail(core::ErrorCode::fit_not_evaluable,
                          std::string("a body needs two sections that ") +
                              (kind == PartBody::solid ? "were measured all round" : "have a contour") + "; there " +
                              (upwards.empty() ? "is none" : "is one"));
    std::stable_sort(upwards.begin(), upwards.end(), [](auto* a, auto* b) { return a->z_mm < b->z_mm; });
    const auto rows = part_rows(upwards);
    if (!rows) return tl::unexpected(rows.error());
    const auto fit = fitting::fit_surface(*rows, {.through_rows = true});
    if (!fit) return tl::unexpected(fit.error());
    const fitting::Surface& surface = fit->surface;
    cad::SplineNet& net = body.net;
    net.knots_u = surface.u().knots();
    net.knots_v = surface.v().knots();
    net.closed_u = true;
    net.count_u = surface.u().controls();
    for (std::size_t j = 0; j < surface.v().controls(); ++j)
        for (std::size_t i = 0; i < net.count_u; ++i)
            net.controls.push_back(surface.control(i, j));
    const fitting::SurfaceIndex index(surface);
    if (kind == PartBody::surface) net.holes = holes_of(part, upwards, surface, index);
    measure_off(upwards, index, body.written);
    return body;
}

/// For who opens the file: what it passes over, and how well it fits.
std::string description_of(const WrittenBody& body, std::size_t sections) {
    std::string text;
    if (!body.passed_over.empty())
        text = "passes over " + std::to_string(body.passed_over.size()) + " of " + std::to_string(sections) +
               " sections, which were not measured all round; ";
    return text + "the measured contours are at most " + core::fixed(core::um_from_mm(body.off_max_mm), 3) +
           " um off its surface (rms " + core::fixed(core::um_from_mm(body.off_rms_mm), 3) + " um)";
}

}  // namespace

core::Result<WrittenBody> export_step(const PartResult& part, PartBody kind, const std::string& file) {
    auto body = body_of(part, kind);
    if (!body) return tl::unexpected(body.error());
    cad::StepOptions options;
    options.form = kind == PartBody::solid ? cad::BodyForm::solid : cad::BodyForm::surface;
    options.name = part.part_serial.empty() ? part.part_name : part.part_name + " " + part.part_serial;
    options.description = description_of(body->written, part.sections.size());
    if (auto status = cad::write_step(body->net, options, file); !status) return tl::unexpected(status.error());
    return std::move(body->written);
}

core::Result<WrittenBody> export_stl(const PartResult& part, const std::string& file) {
    auto body = body_of(part, PartBody::solid);
    if (!body) return tl::unexpected(body.error());
    if (auto status = cad::write_stl(body->net, triangle_deflection_mm, file); !status)
        return tl::unexpected(status.error());
    return std::move(body->written);
}

}  // namespace cmm::acquisition
