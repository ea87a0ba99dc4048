// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bench/pictures/pictures.hpp"
#include "core/units.hpp"
#include "support/compared_methods.hpp"

namespace cmm::pictures {
namespace {

using namespace fitting;

constexpr std::size_t sections = 25, shown = 12;
constexpr double panel_px = 64, gap_px = 24, lowest_um = -12.0, highest_um = 72.0;

}  // namespace

std::string compensation() {
    const families::ComparedBlade blade(families::Family::fan, 1, sections, true);
    const auto names = compensation_method_names();
    const double height = 30 + static_cast<double>(names.size()) * (panel_px + gap_px) + 20;
    svg::Picture picture(width_px, height, "error of one contour by each method of compensation");
    double top = 30;
    picture.text("strong", {left_px, 14}, svg::Anchor::start,
                 "off the truth in \u00b5m, along one section of a twisted fan blade, 1 \u00b5m noise");
    for (const auto name : names) {
        const auto fit = blade.section(*compensation_method_from(name), shown);
        if (!fit) continue;
        const auto errors = blade.along(*fit, shown);
        std::vector<double> um;
        for (const double error : errors.error_mm)
            um.push_back(core::um_from_mm(error));
        const auto frame = frame_at(top, panel_px, {0.0, lowest_um}, {errors.arc_length_mm.back(), highest_um});
        const bool last = name == names.back();
        frame.draw_axes(picture, last ? "along the contour from the leading edge in mm" : "", "", 10, 4);
        picture.clip(frame.corner(), frame.size());
        picture.path("measured", svg::polyline(graph(frame, errors.arc_length_mm, um), false, 0.1), 1.2);
        picture.unclip();
        picture.text("strong", {left_px + 0.4 * (width_px - left_px), top + 14}, svg::Anchor::middle, name);
        top += panel_px + gap_px;
    }
    return picture.finish();
}

}  // namespace cmm::pictures
