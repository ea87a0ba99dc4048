// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "acquisition/gauge_numbers.hpp"
#include "acquisition/gauge_study.hpp"
#include "acquisition/plot_frame.hpp"
#include "acquisition/svg.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using svg::Anchor;
using svg::Picture;
using svg::PlotFrame;

constexpr double study_width = 560, study_height = 220, plot_top = 10, plot_bottom = 38;
constexpr std::size_t named_places = 12, colours = 4, longest_name = 9;
constexpr double used_width = 0.7;  // of a place; the rest keeps it from its neighbours

/// A value where it stands on the x axis: `place` of so many, and within it `turn` of so many.
struct StudyDot {
    Vector2d at;
    std::size_t appraiser;
};

double position(std::size_t place, std::size_t turn, std::size_t turns) {
    const double step = used_width / static_cast<double>(turns);
    return static_cast<double>(place) + 0.5 + (static_cast<double>(turn) - 0.5 * static_cast<double>(turns - 1)) * step;
}

std::string short_name(const std::string& name) {
    if (name.size() <= longest_name) return name;
    std::string cut = name.substr(0, longest_name - 1);
    while (!cut.empty() && (static_cast<unsigned char>(cut.back()) & 0xc0U) == 0x80U)
        cut.pop_back();  // not in the middle of a letter
    if (!cut.empty() && static_cast<unsigned char>(cut.back()) >= 0xc0U) cut.pop_back();
    return cut + "\u2026";
}

PlotFrame frame_of(double left, double width, std::size_t places, const std::vector<StudyDot>& dots) {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (const auto& dot : dots) {
        low = std::min(low, dot.at.y());
        high = std::max(high, dot.at.y());
    }
    const double pad = std::max({0.08 * (high - low), 1e-6 * std::max(std::abs(low), std::abs(high)), 1e-9});
    return {{left, plot_top},
            {width, study_height - plot_top - plot_bottom},
            {0.0, low - pad},
            {static_cast<double>(places), high + pad}};
}

void draw_places(Picture& picture, const PlotFrame& frame, const std::vector<std::string>& names,
                 const std::string& title) {
    frame.draw_y_ticks(picture, 4);
    picture.box("frame", frame.corner(), frame.size());
    if (names.size() <= named_places) {
        for (std::size_t i = 0; i < names.size(); ++i)
            picture.text("", {frame.px({static_cast<double>(i) + 0.5, 0.0}).x(), frame.bottom_px() + 14},
                         Anchor::middle, short_name(names[i]));
    }
    frame.draw_titles(picture, title, {});
}

void draw_dots(Picture& picture, const PlotFrame& frame, const std::vector<StudyDot>& dots) {
    for (const auto& [at, appraiser] : dots)
        picture.circle("by-" + std::to_string(appraiser % colours), frame.px(at), 2.4);
}

/// The means of an appraiser, part by part: lines that are not parallel are an interaction.
void draw_means(Picture& picture, const PlotFrame& frame, const GaugeStudy& study, const std::vector<StudyDot>& dots) {
    for (std::size_t j = 0; j < study.appraisers.size(); ++j) {
        std::vector<Vector2d> line;
        for (std::size_t i = 0; i < study.parts.size(); ++i) {
            const double x = position(i, j, study.appraisers.size());
            double sum = 0.0, count = 0.0;
            for (const auto& dot : dots)
                if (std::abs(dot.at.x() - x) < 1e-9) {
                    sum += dot.at.y();
                    ++count;
                }
            if (count > 0.0) line.push_back(frame.px({x, sum / count}));
        }
        picture.path("trend", svg::polyline(line, false));
    }
}

std::vector<double> means_of_parts(const GaugeStudy& study, const StudyCharacteristic& one) {
    std::vector<double> sums(study.parts.size(), 0.0), counts(study.parts.size(), 0.0);
    for (const auto& value : one.values) {
        sums[value.part] += value.value;
        ++counts[value.part];
    }
    for (std::size_t i = 0; i < sums.size(); ++i)
        sums[i] /= std::max(1.0, counts[i]);
    return sums;
}

}  // namespace

std::string study_figure(const GaugeStudy& study, const StudyCharacteristic& one) {
    if (one.values.empty()) return {};
    const auto [unit, factor] = gauge_scale(one.unit);
    const auto means = means_of_parts(study, one);
    const double large = one.unit == Unit::mm ? 1.0 : factor;  // sizes are in mm, differences in um
    std::vector<StudyDot> by_part, by_appraiser;
    for (const auto& [part, appraiser, value] : one.values) {
        by_part.push_back({{position(part, appraiser, study.appraisers.size()), large * value}, appraiser});
        by_appraiser.push_back(
            {{position(appraiser, part, study.parts.size()), factor * (value - means[part])}, appraiser});
    }
    Picture picture(study_width, study_height, one.name + " by part and appraiser");
    const auto left = frame_of(62, 290, study.parts.size(), by_part);
    const auto right = frame_of(406, 144, study.appraisers.size(), by_appraiser);
    draw_places(picture, left, study.parts, "part");
    picture.text("", {11, plot_top + 0.5 * left.size().y()}, Anchor::middle, one.unit == Unit::mm ? "mm" : unit, true);
    draw_means(picture, left, study, by_part);
    draw_dots(picture, left, by_part);
    draw_places(picture, right, study.appraisers, "off the mean of the part");
    picture.text("", {362, plot_top + 0.5 * right.size().y()}, Anchor::middle, one.unit == Unit::mm ? "\u00b5m" : unit,
                 true);
    const double nought = right.px({0.0, 0.0}).y();
    picture.line("zero", {right.corner().x(), nought}, {right.right_px(), nought});
    draw_dots(picture, right, by_appraiser);
    return picture.finish();
}

}  // namespace cmm::acquisition
