// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_figures.hpp"

#include "acquisition/figure_layout.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::Zone;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;
using namespace figure;

void draw_overlay(Picture& picture, const PlotFrame& frame, const SectionResult& section, const SurfacePoints& points) {
    frame.draw_axes(picture, "x in mm", "y in mm", 8, 5);
    picture.clip(frame.corner(), frame.size());
    picture.path("nominal", svg::polyline(frame.px(section.nominal_contour), true));
    picture.path("measured", contour_path(section, frame.px(contour_positions(section))));
    if (!section.has_contour()) picture.path("dot", svg::dots(frame.px(points.used)));
    picture.path("reject", svg::crosses(frame.px(points.rejected), 3.0));
    picture.unclip();
    const auto name_edge = [&](Zone edge, const Vector2d& other, std::string_view name) {
        const auto nose = section.nose_mm(edge);
        if (!nose) return;
        const Vector2d out = (*nose - other).normalized();
        const Vector2d at = frame.px(*nose) + Vector2d(out.x() * 14, -out.y() * 14 + 4);
        picture.text("strong on", at, Anchor::middle, name);
    };
    if (!section.has_contour()) return;
    name_edge(Zone::le, section.fit->te_point_mm, "LE");
    name_edge(Zone::te, section.fit->le_point_mm, "TE");
}

Box edge_box(const SectionResult& section, Zone edge) {
    const bool le = edge == Zone::le;
    const auto& fit = *section.fit;
    const auto& arc = le ? fit.le : fit.te;
    const Vector2d nose = le ? fit.le_point_mm : fit.te_point_mm;
    const Vector2d inward = ((le ? fit.te_point_mm : fit.le_point_mm) - nose).normalized();
    const double radius = arc.valid ? arc.radius_mm : 0.02 * fit.chord_mm;
    Box box;
    box.add(nose + 1.1 * radius * inward);
    box.grow(1.9 * radius);
    return box;
}

void draw_edge(Picture& picture, const PlotFrame& frame, const SectionResult& section, Zone edge,
               const SurfacePoints& points) {
    const auto& arc = edge == Zone::le ? section.fit->le : section.fit->te;
    const auto nominal = svg::polyline(frame.px(section.nominal_contour), true);
    frame.draw_axes(picture, "x in mm", "y in mm", 4, 4);
    picture.clip(frame.corner(), frame.size());
    if (const auto limit = zone_limits_mm(section)[static_cast<std::size_t>(edge)]; limit && !nominal.empty()) {
        // A line as wide as the tolerance zone is the zone.
        picture.path("tolerance", nominal, *limit * frame.scale_x());
    }
    picture.path("nominal", nominal);
    if (arc.valid) {
        const auto centre = frame.px(arc.centre_mm);
        picture.circle("arc", centre, arc.radius_mm * frame.scale_x());
        picture.path("centre", "M" + svg::number(centre.x() - 4) + " " + svg::number(centre.y()) + "h8m-4 -4v8");
    }
    picture.path("measured", contour_path(section, frame.px(contour_positions(section))));
    picture.path("dot", svg::dots(frame.px(points.used)));
    picture.path("reject", svg::crosses(frame.px(points.rejected), 4.0));
    picture.unclip();
    picture.text("strong on", frame.corner() + Vector2d(8, 16), Anchor::start, edge == Zone::le ? "LE" : "TE");
}

}  // namespace

std::string radius_text(const SectionResult& section, Zone edge) {
    const auto* radius = section.find(edge == Zone::le ? "le_radius" : "te_radius");
    if (!section.has_contour() || radius == nullptr) return {};
    if (!radius->value) return "no circle: " + radius->note;
    return "r " + core::fixed(*radius->value, 4) + " \u00b1 " + core::fixed(radius->u95.value_or(0.0), 4) + " mm" +
           (radius->note.empty() ? "" : ", " + radius->note);
}

std::string overlay_figure(const SectionResult& section, double ball_radius_mm) {
    constexpr double width = page_width;
    const auto points = surface_points(section, ball_radius_mm);
    const auto box = page_box(section, points);
    const double height = plot_height(box) + margin_top + margin_bottom;
    Picture picture(width, height,
                    "Section at z " + core::fixed(section.z_mm, 3) + " mm: nominal and measured contour");
    draw_overlay(picture, plane_frame(box, {0, 0}, width, height), section, points);
    return picture.finish();
}

std::string edge_figure(const SectionResult& section, Zone edge, double ball_radius_mm) {
    if (!section.nose_mm(edge)) return {};
    constexpr double width = 270;
    constexpr double height = 250;
    const std::string name = edge == Zone::le ? "Leading edge" : "Trailing edge";
    Picture picture(width, height, name + " at z " + core::fixed(section.z_mm, 3) + " mm");
    draw_edge(picture, plane_frame(edge_box(section, edge), {0, 0}, width, height), section, edge,
              surface_points(section, ball_radius_mm));
    return picture.finish();
}

}  // namespace cmm::acquisition
