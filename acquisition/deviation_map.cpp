// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>
#include <vector>

#include "acquisition/figure_layout.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/surface_deviation.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::um_from_mm;
using fitting::Zone;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;
using namespace figure;

constexpr int steps = 10;  // colours to either side of zero
constexpr double width = 1100, least_height = 220, most_height = 460, row_height = 26;
constexpr double scale_room = 78;         // for the colour scale at the right
constexpr double strip_share = 0.92;      // of the distance of sections: strips do not touch, nothing is filled in
constexpr double shown_quantile = 0.995;  // without limits the scale ends there

/// Blue where material is missing, red where there is too much; legible on paper and on screens of either kind.
std::string colour(int step) {
    constexpr std::array<std::array<double, 3>, 5> stops{
        {{33, 102, 172}, {146, 197, 222}, {242, 242, 242}, {244, 165, 130}, {178, 24, 43}}};
    const double at = 2.0 + 2.0 * static_cast<double>(step) / steps;
    const auto low = static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, 3.0));
    const double share = at - static_cast<double>(low);
    std::string text = "#";
    for (std::size_t c = 0; c < 3; ++c) {
        char hex[3];
        std::snprintf(hex, sizeof hex, "%02x",
                      static_cast<unsigned>(std::lround(stops[low][c] + share * (stops[low + 1][c] - stops[low][c]))));
        text += hex;
    }
    return text;
}

bool has_map(const SectionResult& section) {
    return section.has_contour() && section.deviation_mm.size() == section.fit->contour.size();
}

/// A section cut open at the TE: where its contour points lie right (counter-clockwise) or left of the LE nose, mm.
struct Strip {
    const SectionResult* section;
    double low_z, high_z;  // that it is drawn for
    std::vector<double> from_mm, to_mm;
    std::vector<std::optional<double>> deviation_mm;
    bool in_space;  // the deviation: to the surface of the nominal, otherwise in the plane
};

/// The widest limit of any place; without one, nearly the largest deviation, rounded up.
double full_scale_um(const std::vector<Strip>& strips) {
    double limit = 0.0;
    std::vector<double> all;
    for (const auto& strip : strips) {
        for (const auto& limits : limits_along(*strip.section))
            if (limits) limit = std::max({limit, um_from_mm(-limits->below_mm), um_from_mm(limits->above_mm)});
        for (const auto& deviation : strip.deviation_mm)
            if (deviation) all.push_back(um_from_mm(std::abs(*deviation)));
    }
    if (limit > 0.0 || all.empty()) return limit;
    const auto place = all.begin() + static_cast<std::ptrdiff_t>(shown_quantile * static_cast<double>(all.size() - 1));
    std::nth_element(all.begin(), place, all.end());
    return std::max(1.0, std::ceil(*place));
}

Strip unroll(const SectionResult& section) {
    const auto& contour = section.fit->contour;
    const std::size_t n = contour.size();
    const double around =
        contour.back().arc_length_mm + (contour.front().position_mm - contour.back().position_mm).norm();
    const auto te = static_cast<std::size_t>(&nearest_to(contour, section.fit->te_point_mm) - contour.data());
    auto deviation_mm = surface_deviations(section);
    const bool in_space = !deviation_mm.empty();
    if (!in_space) deviation_mm = section.deviation_mm;
    Strip strip{
        &section, section.z_mm, section.z_mm, std::vector<double>(n), std::vector<double>(n), std::move(deviation_mm),
        in_space};
    for (std::size_t i = 0; i < n; ++i) {
        const double turn = i < te ? 0.0 : -around;
        strip.from_mm[i] = turn + contour[i].arc_length_mm;
        strip.to_mm[i] = turn + (i + 1 < n ? contour[i + 1].arc_length_mm : around);
    }
    return strip;
}

/// Each section stands for half the way to its neighbours, or for what is usual where it has none.
std::vector<Strip> strips_of(const PartResult& part) {
    std::vector<Strip> strips;
    for (const auto& section : part.sections)
        if (has_map(section)) strips.push_back(unroll(section));
    std::stable_sort(strips.begin(), strips.end(),
                     [](const Strip& a, const Strip& b) { return a.section->z_mm < b.section->z_mm; });
    const std::size_t n = strips.size();
    std::vector<double> gaps;
    for (std::size_t i = 1; i < n; ++i)
        gaps.push_back(strips[i].section->z_mm - strips[i - 1].section->z_mm);
    auto sorted = gaps;
    std::sort(sorted.begin(), sorted.end());
    const double usual = sorted.empty() ? 1.0 : sorted[sorted.size() / 2];
    for (std::size_t i = 0; i < n; ++i) {
        const auto half = [&](double gap) { return 0.5 * strip_share * std::min(gap, usual); };
        strips[i].low_z -= half(i > 0 ? gaps[i - 1] : usual);
        strips[i].high_z += half(i + 1 < n ? gaps[i] : usual);
    }
    return strips;
}

int step_of(double deviation_um, double full_um) {
    return static_cast<int>(std::lround(std::clamp(deviation_um / full_um, -1.0, 1.0) * steps));
}

/// The strip's rectangles, of neighbouring points of one colour one, by colour; the last: what the ball does not reach.
void add_rectangles(const Strip& strip, double full_um, const PlotFrame& frame, std::vector<std::string>& paths) {
    const auto& deviation = strip.deviation_mm;
    const auto kind = [&](std::size_t i) {
        return deviation[i] ? static_cast<std::size_t>(step_of(um_from_mm(*deviation[i]), full_um) + steps)
                            : paths.size() - 1;
    };
    const double top = frame.px({0.0, strip.high_z}).y(), height = frame.px({0.0, strip.low_z}).y() - top;
    for (std::size_t i = 0; i < deviation.size();) {
        const std::size_t first = i, of = kind(i);
        do
            ++i;
        while (i < deviation.size() && kind(i) == of && strip.from_mm[i] > strip.from_mm[first]);
        const double left = frame.px({strip.from_mm[first], 0.0}).x(), right = frame.px({strip.to_mm[i - 1], 0.0}).x();
        paths[of] += "M" + svg::number(left) + " " + svg::number(top) + "h" + svg::number(right - left) + "v" +
                     svg::number(height) + "h" + svg::number(left - right) + "Z";
    }
}

void draw_scale(Picture& picture, double full_um, double left, double top, double height) {
    const double step_px = height / (2 * steps + 1);
    for (int step = -steps; step <= steps; ++step) {
        const double y = top + step_px * (steps - step);
        picture.fill(colour(step),
                     "M" + svg::number(left) + " " + svg::number(y) + "h16v" + svg::number(step_px + 0.3) + "h-16Z");
    }
    const int digits = full_um < 10.0 ? 1 : 0;
    const auto label = [&](double share, const std::string& text) {
        picture.text("", {left + 22, top + 0.5 * height * (1.0 - share) + 4}, Anchor::start, text);
    };
    label(0.96, "+" + core::fixed(full_um, digits));
    label(0.0, "0 \u00b5m");
    label(-0.96, "\u2212" + core::fixed(full_um, digits));
}

}  // namespace

std::string map_figure(const PartResult& part) {
    const auto strips = strips_of(part);
    const double full_um = full_scale_um(strips);
    if (strips.empty() || !(full_um > 0.0)) return {};
    double left = 0.0, right = 0.0;
    for (const auto& strip : strips) {
        left = std::min(left, *std::min_element(strip.from_mm.begin(), strip.from_mm.end()));
        right = std::max(right, *std::max_element(strip.to_mm.begin(), strip.to_mm.end()));
    }
    const double pad_mm = 0.02 * (right - left);
    const double pad_z = 0.02 * (strips.back().high_z - strips.front().low_z);
    const double height = std::clamp(row_height * static_cast<double>(strips.size()), least_height, most_height);
    constexpr double top = 26;
    const PlotFrame frame({margin_left, top}, {width - margin_left - scale_room, height - top - margin_bottom},
                          {left - pad_mm, strips.front().low_z - pad_z},
                          {right + pad_mm, strips.back().high_z + pad_z});
    const bool in_space = std::any_of(strips.begin(), strips.end(), [](const Strip& strip) { return strip.in_space; });
    Picture picture(width, height,
                    in_space ? "Deviation of all sections from the surface of the nominal, unrolled"
                             : "Deviation of all sections, unrolled");
    frame.draw_axes(picture,
                    in_space
                        ? "along the contour from the leading edge in mm; colour: distance from the nominal surface"
                        : "along the contour from the leading edge in mm",
                    "z in mm", 10, 5);
    picture.clip(frame.corner(), frame.size());
    std::vector<std::string> paths(2 * steps + 2);
    for (const auto& strip : strips)
        add_rectangles(strip, full_um, frame, paths);
    for (int step = -steps; step <= steps; ++step)
        picture.fill(colour(step), paths[static_cast<std::size_t>(step + steps)]);
    picture.path("unknown", paths.back());
    picture.unclip();
    // Counter-clockwise from the LE: the side that the first half of a contour lies on.
    const auto& contour = strips.front().section->fit->contour;
    const bool suction_right = contour[contour.size() / 4].zone == Zone::suction;
    const double y = top - 9;
    picture.text("tag", {frame.px({0.5 * left, 0.0}).x(), y}, Anchor::middle,
                 suction_right ? "PRESSURE SIDE" : "SUCTION SIDE");
    picture.text("tag", {frame.px({0.0, 0.0}).x(), y}, Anchor::middle, "LE");
    picture.text("tag", {frame.px({0.5 * right, 0.0}).x(), y}, Anchor::middle,
                 suction_right ? "SUCTION SIDE" : "PRESSURE SIDE");
    picture.text("tag", {frame.px({left, 0.0}).x(), y}, Anchor::middle, "TE");
    picture.text("tag", {frame.px({right, 0.0}).x(), y}, Anchor::middle, "TE");
    draw_scale(picture, full_um, frame.right_px() + 14, top, frame.size().y());
    return picture.finish();
}

}  // namespace cmm::acquisition
