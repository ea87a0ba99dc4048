// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/plot_frame.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using core::um_from_mm;
using Eigen::Vector2d;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;

struct Trend {
    std::vector<double> z, value, u95;
    std::vector<Decision> decision;
    double limit = 0.0;  ///< 0: none
};

Trend trend_of(const PartResult& part, std::string_view name, double factor) {
    Trend trend;
    for (const auto& section : part.sections) {
        const auto* c = section.find(name);
        if (c == nullptr || !c->value) continue;
        trend.z.push_back(section.z_mm);
        trend.value.push_back(factor * *c->value);
        trend.u95.push_back(factor * c->u95.value_or(0.0));
        trend.decision.push_back(c->decision);
        if (c->upper) trend.limit = std::max(trend.limit, factor * *c->upper);
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
    picture.clip(frame.corner(), frame.size());
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
    picture.unclip();
    return picture.finish();
}

}  // namespace cmm::acquisition
