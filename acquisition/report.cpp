// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "acquisition/characteristic_table.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/report_style.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using svg::escape;

struct Term {
    const char* name;
    const char* title;
};
constexpr std::array terms{Term{"profile_le", "Profile LE"}, Term{"profile_suction", "Profile suction"},
                           Term{"profile_te", "Profile TE"}, Term{"profile_pressure", "Profile pressure"},
                           Term{"le_radius", "LE radius"},   Term{"te_radius", "TE radius"},
                           Term{"chord", "Chord"},           Term{"max_thickness", "Max. thickness"}};

constexpr int report_digits = 4;
constexpr std::size_t listed_points = 200;

std::string mm(double value) {
    return core::fixed(value, report_digits);
}

std::string element(const std::string& tag, const std::string& content) {
    return "<" + tag + ">" + content + "</" + tag.substr(0, tag.find(' ')) + ">\n";
}

std::string figure(const std::string& css, const std::string& caption, const std::string& picture) {
    if (picture.empty()) return {};
    return "<figure class=\"" + css + "\"><figcaption>" + caption + "</figcaption>\n" + picture + "</figure>\n";
}

std::string title_of(const SectionResult& section) {
    return "Section " + std::to_string(section.index) + ", z = " + core::fixed(section.z_mm, 3) + " mm";
}

/// What the section was called in the input, where that says more than its number.
std::string origin_of(const SectionResult& section) {
    if (section.name.empty() || section.name == std::to_string(section.index)) return {};
    return "<span class=\"meta\">from " + escape(section.name) + "</span>";
}

std::string words(Decision decision) {
    std::string text(to_string(decision));
    std::replace(text.begin(), text.end(), '_', ' ');
    return text;
}

bool any_has(const PartResult& part, std::string_view name) {
    return std::any_of(part.sections.begin(), part.sections.end(),
                       [&](const SectionResult& section) { return section.find(name) != nullptr; });
}

const Characteristic* first_of(const PartResult& part, std::string_view name) {
    for (const auto& section : part.sections) {
        if (const auto* c = section.find(name); c != nullptr) return c;
    }
    return nullptr;
}

/// A line of the terminal for the page: real signs, words without underscores, no break inside an inequality.
std::string typeset(std::string reason) {
    const auto replace_all = [&reason](std::string_view from, std::string_view to) {
        for (auto at = reason.find(from); at != std::string::npos; at = reason.find(from, at + to.size())) {
            reason.replace(at, from.size(), to);
        }
    };
    replace_all("+-", "\u00b1");
    replace_all(" mm", "\u00a0mm");
    replace_all(" > ", "\u00a0>\u00a0");
    replace_all("_", " ");
    return reason;
}

std::string verdict_detail(const PartResult& part) {
    const auto total = std::to_string(part.sections.size());
    const auto count = [&](Decision decision) {
        return std::to_string(std::count_if(part.sections.begin(), part.sections.end(),
                                            [&](const auto& section) { return section.decision() == decision; }));
    };
    switch (part.verdict()) {
        case Decision::reject:
            return count(Decision::reject) + " of " + total + " sections outside tolerance";
        case Decision::accept:
            return part.has_requirements() ? "all " + total + " sections within tolerance"
                                           : total + " sections measured, nothing to judge";
        default:
            return part.complete ? count(Decision::undecided) + " of " + total + " sections undecided"
                                 : std::string("the measurement ended early");
    }
}

std::string capital(std::string text) {
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 'a' + 'A');
    return text;
}

std::string fact(const char* name, const std::string& value) {
    return value.empty() ? std::string()
                         : "<div><dt>" + std::string(name) + "</dt><dd>" + escape(value) + "</dd></div>\n";
}

std::string reference_of(const PartResult& part) {
    if (!part.has_nominal) return "none: measured without a nominal";
    const Alignment* alignment = part.alignment();
    return "nominal contour, " + frame_words(alignment != nullptr ? alignment->spec : AlignmentSpec{});
}

/// Of the blade; that of single sections stands with each of them.
std::string alignment_of(const PartResult& part) {
    const Alignment* alignment = part.alignment();
    return alignment != nullptr && alignment->spec.kind == AlignmentKind::blade ? alignment_words(*alignment)
                                                                                : std::string();
}

std::string head(const PartResult& part) {
    std::size_t points = 0;
    std::size_t rejected = 0;
    for (const auto& section : part.sections) {
        points += section.points.size();
        rejected += section.rejected();
    }
    const auto word = verdict_word(part);
    std::string out = "<div class=\"sheet\"><div class=\"head\"><div><p class=\"kind\">Blade section report</p>\n";
    out += element("h1", escape(part.part_name.empty() ? "Unnamed part" : part.part_name)) + "</div>\n";
    out += "<div class=\"verdict " + word + "\"><b>" + capital(word) + "</b><span>" + escape(verdict_detail(part)) +
           "</span></div></div>\n<dl class=\"facts\">\n";
    out += fact("Serial number", part.part_serial) + fact("Machine", part.machine) + fact("Started", part.started_utc) +
           fact("Run", part.run_id) + fact("Stylus ball radius", mm(part.ball_radius_mm) + " mm") +
           fact("Reference", reference_of(part)) + fact("Alignment", alignment_of(part)) +
           fact("Points", std::to_string(points) + " recorded, " + std::to_string(rejected) + " rejected") +
           fact("Software", part.software_version);
    out += "</dl>\n";
    if (const auto reasons = verdict_reasons(part); !reasons.empty()) {
        out += "<div class=\"causes\"><b>" +
               std::string(part.verdict() == Decision::reject ? "Why it is rejected" : "Why it is not accepted") +
               "</b><ul>\n";
        for (const auto& reason : reasons)
            out += element("li", escape(typeset(reason)));
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
    for (const auto& term : terms) {
        const auto* c = first_of(part, term.name);
        if (c == nullptr) continue;
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
        for (const auto& term : terms) {
            if (any_has(part, term.name)) rows += cell(section.find(term.name));
        }
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
           figure("", "<b>Each section is a strip</b>, cut open at the trailing edge; red: too much material",
                  picture) +
           "</div>\n";
}

std::string trends(const PartResult& part) {
    if (part.sections.size() < 2) return {};
    std::string out;
    for (const auto& term : terms) {
        out += figure("", "<b>" + std::string(term.title) + "</b>", trend_figure(part, term.name));
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

std::string compensation_text(const Compensation& compensation) {
    switch (compensation.state) {
        case Compensation::State::final: {
            std::string text = ", 3-D compensation moved the contour by up to " +
                               core::fixed(compensation.change_mm * 1e3, 1) + " \u00b5m";
            constexpr double whole = 0.9995;
            if (compensation.share < whole) text += " (" + core::fixed(100.0 * compensation.share, 1) + " % of it)";
            return text;
        }
        case Compensation::State::provisional:
            return ", provisional";
        case Compensation::State::flat:
            return compensation.note.empty() ? "" : ", 2-D compensation: " + escape(compensation.note);
    }
    return {};
}

std::string again_text(const SectionResult& section) {
    const auto passes = points_of_passes(section);
    if (passes.empty()) return {};
    std::size_t points = 0;
    for (const auto& [pass, count] : passes)
        points += count;
    return ", " + std::to_string(points) + " of them measured again because the section was undecided (" +
           std::to_string(passes.size()) + (passes.size() == 1 ? " pass)" : " passes)");
}

std::string section_sheet(const SectionResult& section, double ball_radius_mm) {
    const auto decision = section.decision();
    std::string out = "<article class=\"sheet section\" id=\"section-" + std::to_string(section.index) + "\"><header>" +
                      element("h3", title_of(section)) + origin_of(section) + "<span class=\"meta\">" +
                      std::to_string(section.points.size()) + " points" + again_text(section) + ", " +
                      std::to_string(section.rejected()) + " rejected";
    if (section.closed()) {
        out += ", scatter " + core::fixed(section.fit->noise_sigma_mm * 1e3, 1) + " \u00b5m (1 \u03c3)";
        out += compensation_text(section.compensation);
        if (section.alignment.spec.kind == AlignmentKind::section ||
            section.alignment.state == Alignment::State::refused)
            out += ", alignment " + escape(alignment_words(section.alignment));
        if (const auto count = section.not_reached(); count > 0)
            out += ", the ball does not reach " + std::to_string(count) + " of " +
                   std::to_string(section.fit->contour.size()) + " contour points";
    }
    out += "</span><span class=\"state " + std::string(to_string(decision)) + "\">" + words(decision) +
           "</span></header>\n";
    if (!section.why.empty()) out += element("p class=\"undecided\"", "Not evaluable: " + escape(section.why));
    const auto whiskers = whisker_figure(section);
    out += "<div class=\"plots\">\n";
    out += figure("half", section.closed() ? "<b>Contour</b>" : "<b>Recorded ball centres</b> and nominal",
                  overlay_figure(section, ball_radius_mm));
    out += figure("half", "<b>Deviations</b> along the normal of the nominal, outwards positive", whiskers);
    out += figure("quarter", "<b>Leading edge</b> " + escape(radius_text(section, fitting::Zone::le)),
                  edge_figure(section, fitting::Zone::le, ball_radius_mm));
    out += figure("quarter", "<b>Trailing edge</b> " + escape(radius_text(section, fitting::Zone::te)),
                  edge_figure(section, fitting::Zone::te, ball_radius_mm));
    out += figure("half", "<b>Deviation against arc length</b> with U95", deviation_figure(section));
    return out + "</div>\n" + rejected_list(section) + "</article>\n";
}

std::string methods(const PartResult& part) {
    std::string rows;
    for (const auto& term : terms) {
        if (const auto* c = first_of(part, term.name); c != nullptr) {
            rows += "<tr><td>" + std::string(term.title) + "</td><td>" + escape(c->method) + "</td></tr>\n";
        }
    }
    return "<h2>Methods</h2>\n<div class=\"sheet methods\"><table><tbody>" + rows + "<tr><td>Decision</td><td>" +
           escape(part.decision_rule) +
           ". A lower limit the other way round.</td></tr>\n"
           "<tr><td>Uncertainty</td><td>U95 is expanded (k = 2) from the scatter of the points about the fit, with "
           "what the neighbouring sections took from the section and what is not known of the lean. Where the ball is "
           "compensated in 2-D, the error of that, r (1/cos lean \u2212 1) by the nominal\u2019s lean at each point, "
           "is "
           "added. The machine\u2019s own length error is not included.</td></tr>\n"
           "<tr><td>Compensation</td><td>3-D: the contour is that of the surface of contacts in the plane of the "
           "section; contacts lie one ball radius inside the surface through the ball centres of all sections, along "
           "its normal. 2-D: the ball radius is taken off in the plane of the section, along the normal of the fitted "
           "curve of ball centres.</td></tr>\n"
           "<tr><td>Alignment</td><td>Nominal frame: the machine\u2019s part frame is that of the nominal. Best fit: "
           "the nominal laid onto the measured contour by closest points, each with the length of contour that it "
           "stands for; of the section by itself (form without location) or of all sections as one rigid body. "
           "Deviations are taken after it, and their U95 holds its standard uncertainty.</td></tr>\n"
           "<tr><td>Reach</td><td>Hollows of the nominal that are sharper than the ball are not compared: the ball "
           "rests "
           "on "
           "both ends and the contour shows the ball there.</td></tr>\n"
           "<tr><td>Rejected points</td><td>Points that lie off the curve through their neighbours, by more than the "
           "larger "
           "of the stated floor and the robust scatter, are marked and not used. Nothing is deleted.</td></tr>\n"
           "</tbody></table></div>\n";
}

}  // namespace

std::string report_html(const PartResult& part) {
    const std::string title = escape(part.part_name + (part.part_serial.empty() ? "" : " " + part.part_serial));
    std::string out =
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n<title>" +
        title + ": " + verdict_word(part) + "</title>\n<style>" + std::string(report_style()) +
        std::string(svg::figure_style()) + "</style></head>\n<body><main>\n";
    out += head(part) + summary_table(part) + characteristic_table(part) + map(part) + trends(part);
    out += "<h2>Sections</h2>\n" + key(part);
    for (const auto& section : part.sections)
        out += section_sheet(section, part.ball_radius_mm);
    out += methods(part);
    out +=
        "<footer>All lengths in millimetres unless said, part frame, z along the span. The numbers of this report with "
        "full resolution: result.json and the CSV files beside it.</footer>\n";
    return out + "</main></body></html>\n";
}

}  // namespace cmm::acquisition
