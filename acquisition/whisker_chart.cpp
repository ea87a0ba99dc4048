// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "acquisition/figure_layout.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;
using namespace figure;

/// Where each whisker stands on the nominal and the limits there.
struct Whisker {
    Vector2d base_px;
    Vector2d out_px;                     ///< unit normal in the picture
    std::optional<double> deviation_mm;  ///< none where the ball does not reach
    std::optional<PointTolerance> limits;
    bool edge;

    bool is_out() const {
        return deviation_mm && limits && (*deviation_mm > limits->above_mm || *deviation_mm < limits->below_mm);
    }
};

std::vector<Whisker> whiskers(const SectionResult& section, const PlotFrame& frame) {
    std::vector<Whisker> out;
    const auto& contour = section.fit->contour;
    const auto limits = limits_along(section);
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const auto& point = contour[i];
        const auto d = section.deviation_mm[i];
        out.push_back({frame.px(point.position_mm - d.value_or(0.0) * point.normal),
                       {point.normal.x(), -point.normal.y()},
                       d,
                       point.measured ? limits[i] : std::nullopt,
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

bool same_limits(const Whisker& a, const Whisker& b) {
    if (!a.limits || !b.limits) return !a.limits && !b.limits;
    return a.limits->below_mm == b.limits->below_mm && a.limits->above_mm == b.limits->above_mm;
}

/// A line as wide as the magnified tolerance zone is the zone; a new line where the limit changes. Limits that differ
/// to either side, or from point to point, are an area: the same width of a line would be wrong.
void draw_tolerance(Picture& picture, const PlotFrame& frame, const std::vector<Whisker>& all, double px_per_mm,
                    bool by_point) {
    picture.clip(frame.corner(), frame.size());
    for (std::size_t first = 0; first < all.size();) {
        std::size_t last = first;
        const auto goes_on = [&] {
            return by_point ? all[last].limits.has_value() == all[first].limits.has_value()
                            : same_limits(all[last], all[first]);
        };
        std::vector<Vector2d> run, above, below;
        const auto add = [&](const Whisker& w) {
            const PointTolerance limits = w.limits.value_or(*all[first].limits);
            run.push_back(w.base_px);
            above.push_back(w.base_px + limits.above_mm * px_per_mm * w.out_px);
            below.push_back(w.base_px + limits.below_mm * px_per_mm * w.out_px);
        };
        for (; last < all.size() && goes_on(); ++last)
            if (all[first].limits) add(all[last]);
        if (all[first].limits) {
            add(all[last % all.size()]);
            above.insert(above.end(), below.rbegin(), below.rend());
            if (by_point)
                picture.path("band", svg::polyline(above, true, 0.005));
            else
                picture.path("tolerance", svg::polyline(run, false, 0.005),
                             (all[first].limits->above_mm - all[first].limits->below_mm) * px_per_mm);
        }
        first = last;
    }
    picture.unclip();
}

void draw_whiskers(Picture& picture, const SectionResult& section, const std::vector<Whisker>& all, double px_per_mm) {
    // Equal steps in the picture: where the contour points lie close (at the edges) most are left out.
    constexpr double spacing_px = 3.0;
    std::string side;
    std::string edge;
    std::string outside;
    const Whisker* last = nullptr;
    for (const auto& w : all) {
        if (!w.deviation_mm) continue;
        const Vector2d tip = w.base_px + *w.deviation_mm * px_per_mm * w.out_px;
        const bool far = last == nullptr || (w.base_px - last->base_px).norm() > spacing_px ||
                         (w.edge && w.out_px.dot(last->out_px) < 0.97);
        if (!far) continue;
        last = &w;
        auto& lines = w.is_out() ? outside : w.edge ? edge : side;
        lines += "M" + svg::number(w.base_px.x()) + " " + svg::number(w.base_px.y()) + "L" + svg::number(tip.x()) +
                 " " + svg::number(tip.y());
    }
    picture.path("whisker-side", side);
    picture.path("whisker-edge", edge);
    picture.path("whisker-out", outside);
    picture.path("envelope", contour_path(section, along_normals(all, [&](const Whisker& w) {
                                              return w.deviation_mm.value_or(0.0) * px_per_mm;
                                          })));
}

}  // namespace

std::string whisker_figure(const SectionResult& section) {
    if (section.deviation_mm.empty() || !section.has_contour()) return {};
    constexpr double width = page_width;
    const auto box = page_box(section, {});
    const double height = plot_height(box) + margin_top + margin_bottom;
    const auto frame = plane_frame(box, {0, 0}, width, height);
    const auto all = whiskers(section, frame);
    double largest = 1e-6;
    for (const auto& w : all) {
        largest = std::max(largest, std::abs(w.deviation_mm.value_or(0.0)));
        if (w.limits) largest = std::max({largest, std::abs(w.limits->below_mm), std::abs(w.limits->above_mm)});
    }
    const double magnification = svg::round_down(longest_whisker_px / (largest * frame.scale_x()));
    const double px_per_mm = magnification * frame.scale_x();

    Picture picture(width, height, "Deviations at z " + core::fixed(section.z_mm, 3) + " mm, magnified");
    draw_tolerance(picture, frame, all, px_per_mm, !section.tolerances.empty());
    frame.draw_axes(picture, "x in mm", "y in mm", 8, 5);
    picture.clip(frame.corner(), frame.size());
    picture.path("nominal", contour_path(section, along_normals(all, [](const Whisker&) { return 0.0; })));
    draw_whiskers(picture, section, all, px_per_mm);
    picture.unclip();

    const double bar_mm = svg::round_down(largest);
    const Vector2d bar(frame.right_px() - 12 - bar_mm * px_per_mm, frame.bottom_px() - 12);
    picture.line("bar", bar, bar + Vector2d(bar_mm * px_per_mm, 0));
    picture.text("on", bar + Vector2d(-6, 4), Anchor::end, svg::number(bar_mm * 1e3) + " \u00b5m");
    picture.text("strong on", frame.corner() + Vector2d(8, 16), Anchor::start,
                 "deviations \u00d7 " + svg::number(magnification));
    return picture.finish();
}

}  // namespace cmm::acquisition
