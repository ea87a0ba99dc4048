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
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::um_from_mm;
using fitting::ContourPoint;
using fitting::Zone;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;
using namespace figure;

constexpr double height = 250;
constexpr double top = 22;  // room for the names of the zones

/// Contour points of one zone that follow each other, counter-clockwise; indices run on past the end of the contour.
struct Run {
    std::size_t first;
    std::size_t count;
    Zone zone;
};

/// All zones in turn, the leading edge first.
std::vector<Run> zone_runs(const std::vector<ContourPoint>& contour) {
    const std::size_t n = contour.size();
    const auto begins = [&](std::size_t i) { return contour[i].zone != contour[(i + n - 1) % n].zone; };
    std::size_t start = 0;
    for (std::size_t i = 0; i < n; ++i) {
        if (begins(i) && contour[i].zone == Zone::le) start = i;
    }
    std::vector<Run> runs;
    for (std::size_t k = 0; k < n; ++k) {
        const auto i = (start + k) % n;
        if (runs.empty() || begins(i)) runs.push_back({start + k, 0, contour[i].zone});
        ++runs.back().count;
    }
    return runs;
}

std::string_view short_name(Zone zone) {
    switch (zone) {
        case Zone::le:
            return "LE";
        case Zone::suction:
            return "SUCTION SIDE";
        case Zone::te:
            return "TE";
        case Zone::pressure:
            return "PRESSURE SIDE";
    }
    return "";
}

using Limits = std::vector<std::optional<PointTolerance>>;

double largest_um(const SectionResult& section, const Limits& limits) {
    const auto& contour = section.fit->contour;
    double largest = 1.0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (!contour[i].measured) continue;
        const double limit = limits[i] ? std::max(std::abs(limits[i]->below_mm), std::abs(limits[i]->above_mm)) : 0.0;
        largest = std::max({largest,
                            um_from_mm(std::abs(section.deviation_mm[i].value_or(0.0)) + section.deviation_u95_mm(i)),
                            um_from_mm(limit)});
    }
    return largest;
}

/// One run unrolled: arc length from its first point against deviation, up to the first point of the next run.
struct Unrolled {
    std::vector<double> at_mm, u95_um;
    std::vector<std::optional<double>> deviation_um;  // none where the ball does not reach
    Limits limits;
};

Unrolled unroll(const SectionResult& section, const Run& run, const Limits& limits) {
    const auto& contour = section.fit->contour;
    Unrolled out;
    for (std::size_t k = 0; k <= run.count; ++k) {
        const auto i = (run.first + k) % contour.size();
        const auto before = (i + contour.size() - 1) % contour.size();
        const double step = k == 0 ? 0.0 : (contour[i].position_mm - contour[before].position_mm).norm();
        out.at_mm.push_back((k == 0 ? 0.0 : out.at_mm.back()) + step);
        const auto deviation = section.deviation_mm[i];
        out.deviation_um.push_back(deviation ? std::optional(um_from_mm(*deviation)) : std::nullopt);
        out.u95_um.push_back(um_from_mm(section.deviation_u95_mm(i)));
        // The run's last place is the next one's first, with the limits of that.
        out.limits.push_back(k == run.count && section.tolerances.empty() ? out.limits.back() : limits[i]);
    }
    return out;
}

/// The measured line in its band over the points [first, last), all of which have a deviation.
void draw_evaluable(Picture& picture, const PlotFrame& frame, const Unrolled& run, std::size_t first,
                    std::size_t last) {
    if (last <= first + 1) return;
    std::vector<Vector2d> line;
    std::vector<Vector2d> band;
    for (std::size_t i = first; i < last; ++i) {
        line.push_back(frame.px({run.at_mm[i], *run.deviation_um[i]}));
        band.push_back(frame.px({run.at_mm[i], *run.deviation_um[i] + run.u95_um[i]}));
    }
    for (std::size_t i = last; i-- > first;) {
        band.push_back(frame.px({run.at_mm[i], *run.deviation_um[i] - run.u95_um[i]}));
    }
    picture.path("sure", svg::polyline(band, true));
    picture.path("measured", svg::polyline(line, false));
}

/// Both limits, as long as there are any.
void draw_limits(Picture& picture, const PlotFrame& frame, const Unrolled& run) {
    std::vector<Vector2d> above, below;
    const auto draw = [&] {
        for (auto* line : {&above, &below}) {
            if (line->size() > 1) picture.path("limit", svg::polyline(*line, false));
            line->clear();
        }
    };
    for (std::size_t i = 0; i < run.at_mm.size(); ++i) {
        if (!run.limits[i]) {
            draw();
            continue;
        }
        above.push_back(frame.px({run.at_mm[i], um_from_mm(run.limits[i]->above_mm)}));
        below.push_back(frame.px({run.at_mm[i], um_from_mm(run.limits[i]->below_mm)}));
    }
    draw();
}

void draw_panel(Picture& picture, const PlotFrame& frame, const Unrolled& run, Zone zone) {
    const double length = run.at_mm.back();
    if (is_edge(zone)) picture.box("zone", frame.corner(), frame.size());
    picture.line("zero", frame.px({0, 0}), frame.px({length, 0}));
    draw_limits(picture, frame, run);
    for (std::size_t first = 0; first < run.at_mm.size();) {
        std::size_t last = first;
        while (last < run.at_mm.size() && run.deviation_um[last])
            ++last;
        draw_evaluable(picture, frame, run, first, last);
        first = last + 1;
    }
    picture.text("tag", {frame.corner().x() + 0.5 * frame.size().x(), frame.corner().y() - 6}, Anchor::middle,
                 short_name(zone));
}

}  // namespace

ZoneLimits zone_limits_mm(const SectionResult& section) {
    ZoneLimits limits;
    for (const auto zone : {Zone::le, Zone::suction, Zone::te, Zone::pressure}) {
        const auto* c = section.find("profile_" + std::string(fitting::to_string(zone)));
        if (c != nullptr) limits[static_cast<std::size_t>(zone)] = c->upper;
    }
    return limits;
}

std::vector<std::optional<PointTolerance>> limits_along(const SectionResult& section) {
    const auto zones = zone_limits_mm(section);
    Limits out(section.fit->contour.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (!section.tolerances.empty()) out[i] = section.tolerances[i];
        const auto width = zones[static_cast<std::size_t>(section.fit->contour[i].zone)];
        if (!width) continue;
        const PointTolerance zone{-0.5 * *width, 0.5 * *width};
        out[i] = out[i] ? PointTolerance{std::max(out[i]->below_mm, zone.below_mm),
                                         std::min(out[i]->above_mm, zone.above_mm)}
                        : zone;
    }
    return out;
}

std::string deviation_figure(const SectionResult& section) {
    if (section.deviation_mm.empty() || !section.has_contour()) return {};
    Picture picture(page_width, height, "Deviation against arc length at z " + core::fixed(section.z_mm, 3) + " mm");
    const auto limits = limits_along(section);
    const double reach = 1.12 * largest_um(section, limits);
    const auto runs = zone_runs(section.fit->contour);
    // The edges are short and matter most: they get half the width of a side, whatever their length.
    const auto share = [](Zone zone) { return is_edge(zone) ? 1.0 : 2.0; };
    double shares = 0.0;
    for (const auto& run : runs)
        shares += share(run.zone);
    double x = margin_left;
    for (const auto& run : runs) {
        const auto unrolled = unroll(section, run, limits);
        const double panel = (page_width - margin_left - margin_right) * share(run.zone) / shares;
        const PlotFrame frame({x, top}, {panel, height - top - margin_bottom}, {0, -reach},
                              {unrolled.at_mm.back(), reach});
        frame.draw_x_ticks(picture, is_edge(run.zone) ? 2 : 4, &run == &runs.back() ? 0.0 : 16.0);
        frame.draw_y_ticks(picture, 6, x == margin_left);
        draw_panel(picture, frame, unrolled, run.zone);
        x += panel;
    }
    const PlotFrame whole({margin_left, top}, {page_width - margin_left - margin_right, height - top - margin_bottom},
                          {0, 0}, {1, 1});
    whole.draw_titles(picture, "arc length within the zone in mm, counter-clockwise", "deviation in \u00b5m");
    return picture.finish();
}

}  // namespace cmm::acquisition
