// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/plot_frame.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::um_from_mm;
using Eigen::Vector2d;
using fitting::Zone;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;

/// Contour points of one zone that follow each other.
struct Run {
    std::size_t first, last;
    Zone zone;
};

std::vector<Run> zone_runs(const std::vector<fitting::ContourPoint>& contour) {
    std::vector<Run> runs;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        if (runs.empty() || runs.back().zone != contour[i].zone) runs.push_back({i, i, contour[i].zone});
        runs.back().last = i;
    }
    return runs;
}

std::string_view short_name(Zone zone) {
    switch (zone) {
        case Zone::le:
            return "LE";
        case Zone::suction:
            return "SUCTION";
        case Zone::te:
            return "TE";
        case Zone::pressure:
            return "PRESSURE";
    }
    return "";
}

double limit_um(const SectionResult& section, Zone zone) {
    const auto* c = section.find("profile_" + std::string(fitting::to_string(zone)));
    return c != nullptr && c->limit_mm ? um_from_mm(*c->limit_mm) : 0.0;
}

double largest_um(const SectionResult& section) {
    const auto& contour = section.fit->contour;
    double largest = 1.0;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        largest = std::max({largest, um_from_mm(std::abs(section.deviation_mm[i]) + contour[i].u95_mm),
                            0.5 * limit_um(section, contour[i].zone)});
    }
    return largest;
}

void draw_zones(Picture& picture, const PlotFrame& frame, const SectionResult& section) {
    const auto& contour = section.fit->contour;
    for (const auto& run : zone_runs(contour)) {
        const double from = frame.px({contour[run.first].arc_length_mm, 0}).x();
        const double to = frame.px({contour[std::min(run.last + 1, contour.size() - 1)].arc_length_mm, 0}).x();
        const bool edge = run.zone == Zone::le || run.zone == Zone::te;
        if (edge) picture.box("zone", {from, frame.corner().y()}, {to - from, frame.size().y()});
        const bool first_half_of_wrapped = run.first == 0 && contour.front().zone == contour.back().zone;
        if (!edge || to - from > 14 || !first_half_of_wrapped) {
            picture.text("tag", {0.5 * (from + to), frame.corner().y() - 5}, Anchor::middle, short_name(run.zone));
        }
        if (const double half = 0.5 * limit_um(section, run.zone); half > 0.0) {
            for (const double y : {half, -half}) {
                const double at = frame.px({0, y}).y();
                picture.line("limit", {from, at}, {to, at});
            }
        }
    }
}

struct Trend {
    std::vector<double> z, value, u95;
    std::vector<Decision> decision;
    double limit = 0.0;  ///< 0: none
};

Trend trend_of(const PartResult& part, std::string_view name, double factor) {
    Trend trend;
    for (const auto& section : part.sections) {
        const auto* c = section.find(name);
        if (c == nullptr || !c->value_mm) continue;
        trend.z.push_back(section.z_mm);
        trend.value.push_back(factor * *c->value_mm);
        trend.u95.push_back(factor * c->u95_mm.value_or(0.0));
        trend.decision.push_back(c->decision);
        if (c->limit_mm) trend.limit = std::max(trend.limit, factor * *c->limit_mm);
    }
    return trend;
}

/// Values with their uncertainty and limit inside; a judged value is seen from zero.
std::pair<double, double> value_range(const Trend& trend, bool from_zero) {
    double low = from_zero ? 0.0 : std::numeric_limits<double>::max();
    double high = trend.limit;
    for (std::size_t i = 0; i < trend.value.size(); ++i) {
        low = std::min(low, trend.value[i] - trend.u95[i]);
        high = i == 0 && !from_zero ? trend.value[i] + trend.u95[i] : std::max(high, trend.value[i] + trend.u95[i]);
    }
    const double pad = std::max(0.08 * (high - low), 1e-4 * std::abs(high));
    return {from_zero ? 0.0 : low - pad, high + pad};
}

}  // namespace

std::string deviation_figure(const SectionResult& section) {
    if (section.deviation_mm.empty() || !section.closed()) return {};
    const Vector2d size(540, 250);
    constexpr double left = 54;
    constexpr double top = 22;
    const auto& contour = section.fit->contour;
    const double reach = 1.12 * largest_um(section);
    const double length = contour.back().arc_length_mm;
    const PlotFrame frame({left, top}, {size.x() - left - 12, size.y() - top - 36}, {0, -reach}, {length, reach});
    Picture picture(size.x(), size.y(), "Deviation against arc length at z " + core::fixed(section.z_mm, 3) + " mm");
    frame.draw_axes(picture, "arc length in mm, counter-clockwise", "deviation in \u00b5m", 8, 6);
    draw_zones(picture, frame, section);

    std::vector<Vector2d> line;
    std::vector<Vector2d> band;
    for (std::size_t i = 0; i < contour.size(); ++i) {
        const double d = um_from_mm(section.deviation_mm[i]);
        line.push_back(frame.px({contour[i].arc_length_mm, d}));
        band.push_back(frame.px({contour[i].arc_length_mm, d + um_from_mm(contour[i].u95_mm)}));
    }
    for (std::size_t i = contour.size(); i-- > 0;) {
        const double d = um_from_mm(section.deviation_mm[i] - contour[i].u95_mm);
        band.push_back(frame.px({contour[i].arc_length_mm, d}));
    }
    picture.line("zero", frame.px({0, 0}), frame.px({length, 0}));
    picture.path("sure", svg::polyline(band, true));
    picture.path("measured", svg::polyline(line, false));
    return picture.finish();
}

std::string trend_figure(const PartResult& part, std::string_view characteristic) {
    const bool profile = characteristic.starts_with("profile_");
    const auto trend = trend_of(part, characteristic, profile ? um_from_mm(1.0) : 1.0);
    if (trend.z.empty()) return {};
    const Vector2d size(270, 176);
    constexpr double left = 58;
    constexpr double top = 10;
    const auto [z_low, z_high] = std::minmax_element(trend.z.begin(), trend.z.end());
    const double z_pad = std::max(0.06 * (*z_high - *z_low), 0.5);
    const auto [low, high] = value_range(trend, profile);
    const PlotFrame frame({left, top}, {size.x() - left - 10, size.y() - top - 36}, {*z_low - z_pad, low},
                          {*z_high + z_pad, high});
    Picture picture(size.x(), size.y(), std::string(characteristic) + " over z");
    frame.draw_axes(picture, "z in mm", {}, 5, 4);
    picture.text("", {11, top + 0.5 * frame.size().y()}, Anchor::middle, profile ? "\u00b5m" : "mm", true);
    if (trend.limit > 0.0) {
        picture.line("limit", frame.px({*z_low - z_pad, trend.limit}), frame.px({*z_high + z_pad, trend.limit}));
    }
    std::vector<Vector2d> line;
    for (std::size_t i = 0; i < trend.z.size(); ++i) {
        line.push_back(frame.px({trend.z[i], trend.value[i]}));
        picture.line("error", frame.px({trend.z[i], trend.value[i] - trend.u95[i]}),
                     frame.px({trend.z[i], trend.value[i] + trend.u95[i]}));
    }
    picture.path("trend", svg::polyline(line, false));
    for (std::size_t i = 0; i < line.size(); ++i)
        picture.circle(to_string(trend.decision[i]), line[i], 3.0);
    return picture.finish();
}

}  // namespace cmm::acquisition
