// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "acquisition/plot_frame.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ContourPoint;
using fitting::Zone;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;

constexpr double margin_left = 54;
constexpr double margin_bottom = 36;
constexpr double margin_top = 12;
constexpr double margin_right = 12;
constexpr double page_width = 540;
constexpr double longest_whisker_px = 24;

bool is_edge(Zone zone) {
    return zone == Zone::le || zone == Zone::te;
}

struct Box {
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::max());
    Vector2d high = Vector2d::Constant(std::numeric_limits<double>::lowest());
    void add(const Vector2d& p) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    void grow(double by) {
        low.array() -= by;
        high.array() += by;
    }
};

struct SurfacePoints {
    std::vector<Vector2d> used;
    std::vector<Vector2d> rejected;
};

/// Good enough for a picture: every 8th point first, then the neighbours of the best.
const ContourPoint& nearest(const std::vector<ContourPoint>& contour, const Vector2d& p) {
    constexpr std::size_t stride = 8;
    const std::size_t n = contour.size();
    std::size_t best = 0;
    double best_squared = std::numeric_limits<double>::max();
    const auto look_at = [&](std::size_t i) {
        const double squared = (contour[i].position_mm - p).squaredNorm();
        if (squared >= best_squared) return;
        best_squared = squared;
        best = i;
    };
    for (std::size_t i = 0; i < n; i += stride)
        look_at(i);
    const std::size_t coarse = best;
    for (std::size_t k = 1; k < stride; ++k) {
        look_at((coarse + k) % n);
        look_at((coarse + n - k % n) % n);
    }
    return contour[best];
}

/// Recorded points less the ball radius along the normal of the nearest contour point; ball centres without a contour.
SurfacePoints surface_points(const SectionResult& section, double ball_radius_mm) {
    SurfacePoints out;
    for (const auto& point : section.points) {
        Vector2d p = point.centre_mm.head<2>();
        if (section.closed()) {
            p -= ball_radius_mm * nearest(section.fit->contour, p).normal;
        }
        (point.verdict.reason == fitting::RejectReason::none ? out.used : out.rejected).push_back(p);
    }
    return out;
}

std::vector<Vector2d> contour_positions(const SectionResult& section) {
    std::vector<Vector2d> out;
    if (!section.closed()) return out;
    for (const auto& point : section.fit->contour)
        out.push_back(point.position_mm);
    return out;
}

Box extent_of(const SectionResult& section, const SurfacePoints& points) {
    Box box;
    for (const auto& p : section.nominal_contour)
        box.add(p);
    for (const auto& p : contour_positions(section))
        box.add(p);
    for (const auto& p : points.used)
        box.add(p);
    for (const auto& p : points.rejected)
        box.add(p);
    if (!(box.high - box.low).allFinite() || (box.high - box.low).minCoeff() < 0.0) box = {{-1, -1}, {1, 1}};
    box.grow(0.04 * (box.high - box.low).maxCoeff());
    return box;
}

/// Overlay and whiskers stand side by side: the same box, with room for the longest whisker, and the same height.
Box page_box(const SectionResult& section, const SurfacePoints& points) {
    auto box = extent_of(section, points);
    box.grow(longest_whisker_px * (box.high - box.low).x() / page_width);
    return box;
}

double plot_height(const Box& box) {
    const Vector2d size = box.high - box.low;
    return std::clamp((page_width - margin_left - margin_right) * size.y() / size.x(), 150.0, 340.0);
}

PlotFrame plane_frame(const Box& box, const Vector2d& corner, double width_px, double height_px) {
    return PlotFrame::equal(corner + Vector2d(margin_left, margin_top),
                            {width_px - margin_left - margin_right, height_px - margin_top - margin_bottom}, box.low,
                            box.high);
}

void draw_overlay(Picture& picture, const PlotFrame& frame, const SectionResult& section, const SurfacePoints& points) {
    frame.draw_axes(picture, "x in mm", "y in mm", 8, 5);
    picture.clip(frame.corner(), frame.size());
    picture.path("nominal", svg::polyline(frame.px(section.nominal_contour), true));
    picture.path("measured", svg::polyline(frame.px(contour_positions(section)), true));
    if (!section.closed()) picture.path("dot", svg::dots(frame.px(points.used)));
    picture.path("reject", svg::crosses(frame.px(points.rejected), 3.0));
    picture.unclip();
    if (!section.closed()) return;
    const auto name_edge = [&](const Vector2d& nose, const Vector2d& other, std::string_view name) {
        const Vector2d out = (nose - other).normalized();
        const Vector2d at = frame.px(nose) + Vector2d(out.x() * 14, -out.y() * 14 + 4);
        picture.text("strong on", at, Anchor::middle, name);
    };
    name_edge(section.fit->le_point_mm, section.fit->te_point_mm, "LE");
    name_edge(section.fit->te_point_mm, section.fit->le_point_mm, "TE");
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
    picture.path("measured", svg::polyline(frame.px(contour_positions(section)), true));
    picture.path("dot", svg::dots(frame.px(points.used)));
    picture.path("reject", svg::crosses(frame.px(points.rejected), 4.0));
    picture.unclip();
    picture.text("strong on", frame.corner() + Vector2d(8, 16), Anchor::start, edge == Zone::le ? "LE" : "TE");
}

/// Where each whisker stands on the nominal and the limits there.
struct Whisker {
    Vector2d base_px;
    Vector2d out_px;  ///< unit normal in the picture
    double deviation_mm;
    std::optional<double> limit_mm;
    bool edge;
};

std::vector<Whisker> whiskers(const SectionResult& section, const PlotFrame& frame) {
    std::vector<Whisker> out;
    const auto& contour = section.fit->contour;
    const auto limits = zone_limits_mm(section);
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const auto& point = contour[i];
        const double d = section.deviation_mm[i];
        out.push_back({frame.px(point.position_mm - d * point.normal),
                       {point.normal.x(), -point.normal.y()},
                       d,
                       limits[static_cast<std::size_t>(point.zone)],
                       is_edge(point.zone)});
    }
    return out;
}

std::vector<Vector2d> along_normals(const std::vector<Whisker>& all, const auto& length_px) {
    std::vector<Vector2d> out;
    out.reserve(all.size());
    for (const auto& w : all)
        out.push_back(w.base_px + length_px(w) * w.out_px);
    return out;
}

/// A line as wide as the magnified tolerance zone is the zone; a new line where the limit changes.
void draw_tolerance(Picture& picture, const PlotFrame& frame, const std::vector<Whisker>& all, double px_per_mm) {
    picture.clip(frame.corner(), frame.size());
    for (std::size_t first = 0; first < all.size();) {
        std::vector<Vector2d> run;
        std::size_t last = first;
        for (; last < all.size() && all[last].limit_mm == all[first].limit_mm; ++last)
            run.push_back(all[last].base_px);
        run.push_back(all[last % all.size()].base_px);
        if (all[first].limit_mm)
            picture.path("tolerance", svg::polyline(run, false, 0.005), *all[first].limit_mm * px_per_mm);
        first = last;
    }
    picture.unclip();
}

void draw_whiskers(Picture& picture, const std::vector<Whisker>& all, double px_per_mm) {
    // Equal steps in the picture: where the contour points lie close (at the edges) most are left out.
    constexpr double spacing_px = 3.0;
    std::string side;
    std::string edge;
    std::string outside;
    const Whisker* last = nullptr;
    for (const auto& w : all) {
        const Vector2d tip = w.base_px + w.deviation_mm * px_per_mm * w.out_px;
        const bool far = last == nullptr || (w.base_px - last->base_px).norm() > spacing_px ||
                         (w.edge && w.out_px.dot(last->out_px) < 0.97);
        if (!far) continue;
        last = &w;
        const bool over = w.limit_mm && 2.0 * std::abs(w.deviation_mm) > *w.limit_mm;
        auto& lines = over ? outside : w.edge ? edge : side;
        lines += "M" + svg::number(w.base_px.x()) + " " + svg::number(w.base_px.y()) + "L" + svg::number(tip.x()) +
                 " " + svg::number(tip.y());
    }
    picture.path("whisker-side", side);
    picture.path("whisker-edge", edge);
    picture.path("whisker-out", outside);
    picture.path("envelope",
                 svg::polyline(along_normals(all, [&](const Whisker& w) { return w.deviation_mm * px_per_mm; }), true));
}

}  // namespace

ZoneLimits zone_limits_mm(const SectionResult& section) {
    ZoneLimits limits;
    for (const auto zone : {Zone::le, Zone::suction, Zone::te, Zone::pressure}) {
        const auto* c = section.find("profile_" + std::string(fitting::to_string(zone)));
        if (c != nullptr) limits[static_cast<std::size_t>(zone)] = c->limit_mm;
    }
    return limits;
}

std::string radius_text(const SectionResult& section, Zone edge) {
    if (!section.closed()) return {};
    const auto& arc = edge == Zone::le ? section.fit->le : section.fit->te;
    if (!arc.valid) return "no circle: " + arc.why;
    return "r " + core::fixed(arc.radius_mm, 4) + " \u00b1 " + core::fixed(arc.radius_u95_mm, 4) + " mm";
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
    if (!section.closed()) return {};
    constexpr double width = 270;
    constexpr double height = 250;
    const std::string name = edge == Zone::le ? "Leading edge" : "Trailing edge";
    Picture picture(width, height, name + " at z " + core::fixed(section.z_mm, 3) + " mm");
    draw_edge(picture, plane_frame(edge_box(section, edge), {0, 0}, width, height), section, edge,
              surface_points(section, ball_radius_mm));
    return picture.finish();
}

std::string whisker_figure(const SectionResult& section) {
    if (section.deviation_mm.empty() || !section.closed()) return {};
    constexpr double width = page_width;
    const auto box = page_box(section, {});
    const double height = plot_height(box) + margin_top + margin_bottom;
    const auto frame = plane_frame(box, {0, 0}, width, height);
    const auto all = whiskers(section, frame);
    double largest = 1e-6;
    for (const auto& w : all) {
        largest = std::max({largest, std::abs(w.deviation_mm), 0.5 * w.limit_mm.value_or(0.0)});
    }
    const double magnification = svg::round_down(longest_whisker_px / (largest * frame.scale_x()));
    const double px_per_mm = magnification * frame.scale_x();

    Picture picture(width, height, "Deviations at z " + core::fixed(section.z_mm, 3) + " mm, magnified");
    draw_tolerance(picture, frame, all, px_per_mm);
    frame.draw_axes(picture, "x in mm", "y in mm", 8, 5);
    picture.clip(frame.corner(), frame.size());
    picture.path("nominal", svg::polyline(along_normals(all, [](const Whisker&) { return 0.0; }), true));
    draw_whiskers(picture, all, px_per_mm);
    picture.unclip();

    const double bar_mm = svg::round_down(largest);
    const Vector2d bar(frame.right_px() - 12 - bar_mm * px_per_mm, frame.bottom_px() - 12);
    picture.line("bar", bar, bar + Vector2d(bar_mm * px_per_mm, 0));
    picture.text("on", bar + Vector2d(-6, 4), Anchor::end, svg::number(bar_mm * 1e3) + " \u00b5m");
    picture.text("strong on", frame.corner() + Vector2d(8, 16), Anchor::start,
                 "deviations \u00d7 " + svg::number(magnification));
    return picture.finish();
}

std::string section_svg(const SectionResult& section, double ball_radius_mm) {
    constexpr double width = 860;
    constexpr double overlay_width = 590;
    constexpr double height = 500;
    const auto points = surface_points(section, ball_radius_mm);
    Picture picture(width, height, "Section at z " + core::fixed(section.z_mm, 3) + " mm");
    const bool edges = section.closed();
    const auto frame = plane_frame(extent_of(section, points), {0, 0}, edges ? overlay_width : width, height);
    draw_overlay(picture, frame, section, points);
    if (edges) {
        for (const auto edge : {Zone::le, Zone::te}) {
            const Vector2d corner(overlay_width, edge == Zone::le ? 0.0 : 0.5 * height);
            const auto close = plane_frame(edge_box(section, edge), corner, width - overlay_width, 0.5 * height);
            draw_edge(picture, close, section, edge, points);
            picture.text("on", close.corner() + Vector2d(30, 16), Anchor::start, radius_text(section, edge));
        }
    }
    return picture.finish(svg::figure_style());
}

}  // namespace cmm::acquisition
