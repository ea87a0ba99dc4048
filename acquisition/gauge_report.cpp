// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "acquisition/gauge_numbers.hpp"
#include "acquisition/gauge_study.hpp"
#include "acquisition/html.hpp"
#include "acquisition/svg.hpp"

namespace cmm::acquisition {
namespace {

std::string joined_names(const std::vector<std::string>& names) {
    std::string text;
    for (const auto& name : names)
        text += (text.empty() ? "" : ", ") + name;
    return text;
}

std::string study_head(const GaugeStudy& study) {
    std::string out = "<div class=\"sheet\"><p class=\"kind\">Gauge repeatability and reproducibility</p>\n" +
                      html::element("h1", svg::escape(study.part_name)) + "<dl class=\"facts\">\n" +
                      html::fact("Design", gauge_design(study)) + html::fact("Parts", joined_names(study.parts)) +
                      html::fact("Appraisers", joined_names(study.appraisers)) + "</dl>\n";
    const auto notes = gauge_notes(study);
    if (!notes.empty()) {
        out += "<div class=\"causes\"><b>To know beside the numbers</b><ul>\n";
        for (const auto& note : notes)
            out += html::element("li", svg::escape(note));
        out += "</ul></div>\n";
    }
    return out + "</div>\n";
}

std::string study_table(const GaugeStudy& study) {
    const auto titles = gauge_titles();
    // An interval stands small under its number.
    const auto row = [&](const std::vector<std::string>& cells, const std::string& tag) {
        std::string text;
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const bool interval = i + 1 < cells.size() && titles[i + 1] == gauge_interval;
            text += "<" + tag + (i < 2 ? " class=\"word\">" : ">") + svg::escape(cells[i]);
            if (interval) text += "<small>" + svg::escape(cells[++i]) + "</small>";
            text += "</" + tag + ">";
        }
        return "<tr>" + text + "</tr>\n";
    };
    const std::string head = row(titles, "th");
    std::string rows;
    for (const auto& one : study.characteristics)
        rows += row(gauge_row(one), "td");
    return "<h2>Components of variation</h2>\n<div class=\"sheet wide\"><table><thead>" + head + "</thead>\n<tbody>" +
           rows + "</tbody></table></div>\n";
}

std::string study_pictures(const GaugeStudy& study) {
    std::string out = "<h2>Measurements by part and appraiser</h2>\n<div class=\"sheet plots\">\n";
    for (const auto& one : study.characteristics)
        out += html::figure("half", "<b>" + svg::escape(one.name) + "</b> " + svg::escape(one.method),
                            study_figure(study, one));
    return out + "</div>\n";
}

constexpr const char* study_methods =
    "<h2>Methods</h2>\n<div class=\"sheet methods\"><table><tbody>"
    "<tr><td>EV, AV, INT, PV</td><td>standard deviations of repeatability, appraisers, interaction and parts: analysis "
    "of variance, all effects random, AIAG MSA 4th edition, appendix A; negative estimates count as 0</td></tr>\n"
    "<tr><td>INT</td><td>none: its p is above 0.25, and it is pooled with the repeats</td></tr>\n"
    "<tr><td>GRR</td><td>root of the sum of squares of EV, AV and INT</td></tr>\n"
    "<tr><td>95 %</td><td>two-sided interval: chi-square for EV, modified large samples (Burdick, Borror and "
    "Montgomery "
    "2003) for GRR; with two or three appraisers its upper end is far off because two or three do not tell how "
    "appraisers differ</td></tr>\n"
    "<tr><td>%GRR</td><td>GRR of the total variation, the root of the sum of squares of GRR and PV</td></tr>\n"
    "<tr><td>%tolerance</td><td>6 GRR of the width between the limits, or of a profile's zone</td></tr>\n"
    "<tr><td>ndc</td><td>distinct categories, 1.41 PV/GRR without its decimals</td></tr>\n"
    "<tr><td>declared u</td><td>standard uncertainty U95/2 that the single runs state, root mean square; EV/u above 1 "
    "beyond its interval: repeating scatters more than a run says of itself. u also holds what is the same in all runs "
    "(offset error), EV does not</td></tr>\n</tbody></table></div>\n";

}  // namespace

std::string study_html(const GaugeStudy& study) {
    return html::page(study.part_name + ": gauge study",
                      study_head(study) + study_table(study) + study_pictures(study) + study_methods);
}

}  // namespace cmm::acquisition
