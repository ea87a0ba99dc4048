// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>
#include <vector>

#include "acquisition/budget_table.hpp"
#include "acquisition/characteristic_table.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/html.hpp"
#include "acquisition/report_text.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "acquisition/traceability.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using svg::escape;

constexpr int report_digits = 4;
constexpr std::size_t listed_points = 200;

std::string mm(double value) {
    return core::fixed(value, report_digits);
}

/// What the section was called in the input, where that says more than its number.
std::string origin_of(const SectionResult& section) {
    if (section.name.empty() || section.name == std::to_string(section.index)) return {};
    return "<span class=\"meta\">from " + escape(section.name) + "</span>";
}

std::string head(const PartResult& part) {
    const auto word = verdict_word(part);
    std::string out = "<div class=\"sheet\"><div class=\"head\"><div><p class=\"kind\">Blade section report</p>\n";
    out += html::element("h1", escape(part.part_name.empty() ? "Unnamed part" : part.part_name)) + "</div>\n";
    out += "<div class=\"verdict " + word + "\"><b>" + capital(word) + "</b><span>" + escape(verdict_detail(part)) +
           "</span></div></div>\n<dl class=\"facts\">\n";
    for (const auto& [name, value] : report_facts(part))
        out += html::fact(name, value);
    out += "</dl>\n";
    if (const auto reasons = typeset_reasons(part); !reasons.empty()) {
        out += "<div class=\"causes\"><b>" +
               std::string(part.verdict() == Decision::reject ? "Why it is rejected" : "Why it is not accepted") +
               "</b><ul>\n";
        for (const auto& reason : reasons)
            out += html::element("li", escape(reason));
        out += "</ul></div>\n";
    }
    return out + "</div>\n";
}

std::string cell(const Characteristic* c) {
    if (c == nullptr) return "<td></td>";
    if (!c->value) return "<td class=\"not_evaluable\" title=\"" + escape(c->note) + "\">n/e</td>";
    const bool bad = c->decision == Decision::reject || c->decision == Decision::undecided;
    return "<td" + (bad ? " class=\"" + std::string(to_string(c->decision)) + "\"" : std::string()) + " title=\"" +
           escape(c->note) + "\">" + mm(*c->value) + "<small>\u00b1 " + mm(c->u95.value_or(0.0)) + "</small></td>";
}

std::string summary_table(const PartResult& part) {
    std::string header = "<th>Section</th><th>z<small>mm</small></th><th>Points</th><th>Rejected</th>";
    const auto terms = report_terms(part);
    for (const auto& term : terms) {
        const auto* c = first_of(part, term.name);
        header += "<th>" + std::string(term.title) + "<small>" +
                  (c->upper && !c->lower ? "\u2264 " + core::fixed(*c->upper, 3) + " mm" : std::string("mm")) +
                  "</small></th>";
    }
    std::string rows;
    for (const auto& section : part.sections) {
        const auto index = std::to_string(section.index);
        rows.append("<tr><td><a href=\"#section-").append(index).append("\">").append(index);
        rows += "</a></td><td>" + core::fixed(section.z_mm, 3) + "</td><td>" + std::to_string(section.points.size()) +
                "</td><td>" + std::to_string(section.rejected()) + "</td>";
        for (const auto& term : terms)
            rows += cell(section.find(term.name));
        const auto decision = section.decision();
        rows += "<td class=\"word " + std::string(to_string(decision)) + "\">" + words(decision) + "</td></tr>\n";
    }
    return "<h2>Results</h2>\n<div class=\"sheet wide\"><table><thead><tr>" + header +
           "<th class=\"word\">Decision</th></tr></thead>\n<tbody>" + rows + "</tbody></table></div>\n";
}

std::string map(const PartResult& part) {
    const auto picture = map_figure(part);
    if (picture.empty()) return {};
    return "<h2>Deviations over the blade</h2>\n<div class=\"sheet map\">\n" +
           html::figure("", "<b>Each section is a strip</b>, cut open at the trailing edge; red: too much material",
                        picture) +
           "</div>\n";
}

std::string trends(const PartResult& part) {
    if (part.sections.size() < 2) return {};
    std::string out;
    for (const auto& term : report_terms(part)) {
        out += html::figure("", "<b>" + std::string(term.title) + "</b>", trend_figure(part, term.name));
    }
    return out.empty() ? out
                       : "<h2>Over the height of the blade</h2>\n<div class=\"sheet trends\">\n" + out + "</div>\n";
}

std::string key_entry(const char* css, const char* data, const char* label) {
    return "<span><svg class=\"fig\" viewBox=\"0 0 26 10\" aria-hidden=\"true\"><path class=\"" + std::string(css) +
           "\" d=\"" + data + "\"/></svg>" + label + "</span>\n";
}

std::string key(const PartResult& part) {
    constexpr const char* stroke = "M1 5h24";
    std::string out = "<div class=\"key\">\n" + key_entry("measured", stroke, "measured contour") +
                      key_entry("dot", "M7 5h0M19 5h0", "points less ball radius") +
                      key_entry("reject", "M9 1l8 8M9 9l8 -8", "rejected point");
    if (part.has_nominal) {
        constexpr const char* hedge = "M3 1v8M8 1v8M13 1v8M18 1v8M23 1v8";
        out += key_entry("nominal", stroke, "nominal") + key_entry("band", "M1 1h24v8h-24z", "tolerance zone") +
               key_entry("whisker-side", hedge, "deviation, side") +
               key_entry("whisker-edge", hedge, "deviation, LE and TE") +
               key_entry("whisker-out", hedge, "deviation outside the tolerance zone");
    }
    return out + "</div>\n";
}

std::string rejected_list(const SectionResult& section) {
    std::string rows;
    std::size_t listed = 0;
    for (const auto& point : section.points) {
        if ((point.verdict.reason == fitting::RejectReason::none && !point.verdict.kept) || listed == listed_points)
            continue;
        ++listed;
        std::string reason(point.verdict.kept ? "kept by operator" : fitting::to_string(point.verdict.reason));
        std::replace(reason.begin(), reason.end(), '_', ' ');
        rows += "<tr><td>" + std::to_string(point.sequence) + "</td><td>" + mm(point.centre_mm.x()) + "</td><td>" +
                mm(point.centre_mm.y()) + "</td><td>" + mm(point.centre_mm.z()) + "</td><td>" +
                mm(point.verdict.residual_mm) + "</td><td class=\"word\">" + reason + "</td></tr>\n";
    }
    if (listed == 0) return {};
    const auto kept = static_cast<std::size_t>(std::count_if(
        section.points.begin(), section.points.end(), [](const RecordedPoint& point) { return point.verdict.kept; }));
    const auto total = section.rejected() + kept;
    std::string title =
        std::to_string(section.rejected()) + (section.rejected() == 1 ? " rejected point" : " rejected points");
    if (kept > 0) title += ", " + std::to_string(kept) + " kept by the operator";
    if (listed < total) title += " (the first " + std::to_string(listed) + "; all of them in rejected.csv)";
    return "<details><summary>" + title +
           "</summary><div "
           "class=\"wide\"><table><thead><tr><th>Sample</th><th>x<small>mm</small></th><th>y<small>mm</small>"
           "</th><th>z<small>mm</small></th><th>Residual<small>mm</small></th><th "
           "class=\"word\">Reason</th></tr></thead>"
           "<tbody>" +
           rows + "</tbody></table></div></details>\n";
}

std::string section_sheet(const SectionResult& section, double ball_radius_mm) {
    const auto decision = section.decision();
    std::string out = "<article class=\"sheet section\" id=\"section-" + std::to_string(section.index) + "\"><header>" +
                      html::element("h3", title_of(section)) + origin_of(section) + "<span class=\"meta\">" +
                      escape(summary_of(section));
    out += "</span><span class=\"state " + std::string(to_string(decision)) + "\">" + words(decision) +
           "</span></header>\n";
    if (!section.all_round()) out += html::element("p class=\"undecided\"", escape(not_all_round_text(section)));
    const auto whiskers = whisker_figure(section);
    out += "<div class=\"plots\">\n";
    out += html::figure("half", section.has_contour() ? "<b>Contour</b>" : "<b>Recorded ball centres</b> and nominal",
                        overlay_figure(section, ball_radius_mm));
    out += html::figure("half", "<b>Deviations</b> along the normal of the nominal, outwards positive", whiskers);
    out += html::figure("quarter", "<b>Leading edge</b> " + escape(radius_text(section, fitting::Zone::le)),
                        edge_figure(section, fitting::Zone::le, ball_radius_mm));
    out += html::figure("quarter", "<b>Trailing edge</b> " + escape(radius_text(section, fitting::Zone::te)),
                        edge_figure(section, fitting::Zone::te, ball_radius_mm));
    out += html::figure("half", "<b>Deviation against arc length</b> with U95", deviation_figure(section));
    return out + "</div>\n" + rejected_list(section) + "</article>\n";
}

std::string pairs_table(const std::string& title, const std::vector<std::pair<std::string, std::string>>& pairs) {
    std::string rows;
    for (const auto& [name, text] : pairs)
        rows += "<tr><td>" + escape(name) + "</td><td>" + escape(text) + "</td></tr>\n";
    return "<h2>" + title + "</h2>\n<div class=\"sheet methods\"><table><tbody>" + rows + "</tbody></table></div>\n";
}

}  // namespace

std::string report_html(const PartResult& part) {
    const std::string title =
        part.part_name + (part.part_serial.empty() ? "" : " " + part.part_serial) + ": " + verdict_word(part);
    std::string out =
        head(part) + summary_table(part) + characteristic_table(part) + budget_table(part) + map(part) + trends(part);
    out += "<h2>Sections</h2>\n" + key(part);
    for (const auto& section : part.sections)
        out += section_sheet(section, part.ball_radius_mm);
    out += pairs_table("Methods", report_methods(part)) + pairs_table("Traceability", traceability(part));
    out +=
        "<footer>All lengths in millimetres unless said, part frame, z along the span. The numbers of this report with "
        "full resolution: result.json and the CSV files beside it.</footer>\n";
    return html::page(title, out);
}

}  // namespace cmm::acquisition
