// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/budget_table.hpp"
#include "acquisition/characteristic_table.hpp"
#include "acquisition/exports.hpp"
#include "acquisition/report_text.hpp"
#include "acquisition/section_figures.hpp"
#include "acquisition/svg.hpp"
#include "acquisition/traceability.hpp"
#include "core/text.hpp"
#include "pdf/pages.hpp"

namespace cmm::acquisition {
namespace {

using pdf::Cell;
using pdf::Column;
using pdf::Ink;

constexpr int paper_digits = 4;

Ink ink_of(Decision decision) {
    switch (decision) {
        case Decision::accept:
            return Ink::good;
        case Decision::reject:
            return Ink::bad;
        case Decision::undecided:
            return Ink::open;
        case Decision::not_evaluable:
            return Ink::soft;
        case Decision::reported:
            return Ink::plain;
    }
    return Ink::plain;
}

std::string verdict_on_paper(const PartResult& part) {
    return capital(verdict_word(part));
}

Cell paper_cell(const Characteristic* c) {
    if (c == nullptr) return {};
    if (!c->value) return {"n/e", Ink::soft};
    const bool bad = c->decision == Decision::reject || c->decision == Decision::undecided;
    return {core::fixed(*c->value, paper_digits) + "\n\u00b1 " + core::fixed(c->u95.value_or(0.0), paper_digits),
            bad ? ink_of(c->decision) : Ink::plain};
}

void add_results(pdf::Pages& pages, const PartResult& part) {
    const auto terms = report_terms(part);
    std::vector<Column> columns{{"Sec.", 0.6, true}, {"z mm", 0.95, true}, {"Points", 0.9, true}, {"Rej.", 0.6, true}};
    for (const auto& term : terms) {
        const auto* c = first_of(part, term.name);
        const bool limited = c->upper && !c->lower;
        columns.push_back(
            {std::string(term.title) + (limited ? " \u2264 " + core::fixed(*c->upper, 3) : std::string()) + " mm", 1.2,
             true});
    }
    columns.push_back({"Decision", 1.1, false});
    std::vector<std::vector<Cell>> rows;
    for (const auto& section : part.sections) {
        std::vector<Cell> row{{std::to_string(section.index)},
                              {core::fixed(section.z_mm, 3)},
                              {std::to_string(section.points.size())},
                              {std::to_string(section.rejected())}};
        for (const auto& term : terms)
            row.push_back(paper_cell(section.find(term.name)));
        row.push_back({words(section.decision()), ink_of(section.decision())});
        rows.push_back(std::move(row));
    }
    pages.heading("Results");
    pages.table(columns, rows);
}

void add_characteristics(pdf::Pages& pages, const PartResult& part) {
    const auto asked = asked_rows(part);
    if (asked.empty()) return;
    const std::vector<Column> columns{{"Sec.", 0.9, true},
                                      {"Characteristic", 2.4, false},
                                      {"", 0.8, false},
                                      {"Value", 1.5, true},
                                      {"U95", 1.2, true},
                                      {"Nominal", 1.5, true},
                                      {"Deviation", 1.9, true},
                                      {"Lower", 1.5, true},
                                      {"Upper", 1.5, true},
                                      {"Decision", 1.6, false},
                                      {"Method, or why it is not evaluable", 3.7, false}};
    std::vector<std::vector<Cell>> rows;
    for (const auto& row : asked)
        rows.push_back({{row.section},
                        {row.name},
                        {row.unit},
                        {row.value.empty() ? "n/e" : row.value},
                        {row.u95},
                        {row.nominal},
                        {row.deviation},
                        {row.lower},
                        {row.upper},
                        {words(row.decision), ink_of(row.decision)},
                        {row.method, Ink::soft}});
    pages.heading("Characteristics");
    pages.table(columns, rows);
}

/// Of a column whose title is broken at blanks alone.
double width_for(std::string_view title) {
    constexpr double of_letter = 0.18, of_numbers = 1.4;
    std::size_t longest = 0;
    for (const auto word : core::split(title, ' '))
        longest = std::max(longest, word.size());
    return std::max(of_numbers, of_letter * static_cast<double>(longest));
}

void add_budgets(pdf::Pages& pages, const PartResult& part) {
    const auto budgets = budget_rows(part);
    if (budgets.empty()) return;
    std::vector<Column> columns{{"Characteristic", 2.6, false}, {"Sec.", 0.7, true}, {"", 1.2, false}};
    for (const auto& word : budget_words)
        columns.push_back({word.title, width_for(word.title), true});
    columns.push_back({"U95", 1.0, true});
    std::vector<std::vector<Cell>> rows;
    for (const auto& row : budgets) {
        std::vector<Cell> cells{{row.name}, {row.section}, {row.unit}};
        for (const auto& part_text : row.parts)
            cells.push_back({part_text});
        cells.push_back({row.u95});
        rows.push_back(std::move(cells));
    }
    pages.heading("Where the uncertainties come from");
    pages.paragraph(budget_note(), Ink::soft);
    pages.table(columns, rows);
}

void add(std::vector<pdf::Picture>& pictures, std::string caption, const std::string& figure) {
    if (!figure.empty()) pictures.push_back({std::move(caption), svg::on_paper(figure)});
}

void add_section(pdf::Pages& pages, const SectionResult& section, double ball_radius_mm) {
    pages.heading(title_of(section) + ": " + words(section.decision()));
    pages.paragraph(summary_of(section), Ink::soft);
    if (!section.all_round()) pages.paragraph(not_all_round_text(section), Ink::open);
    std::vector<pdf::Picture> wide, edges;
    add(wide, section.has_contour() ? "Contour" : "Recorded ball centres and nominal",
        overlay_figure(section, ball_radius_mm));
    add(wide, "Deviations along the normal of the nominal, outwards positive", whisker_figure(section));
    pages.pictures(wide, 2);
    add(edges, "Leading edge: " + radius_text(section, fitting::Zone::le),
        edge_figure(section, fitting::Zone::le, ball_radius_mm));
    add(edges, "Trailing edge: " + radius_text(section, fitting::Zone::te),
        edge_figure(section, fitting::Zone::te, ball_radius_mm));
    add(edges, "Deviation against arc length with U95", deviation_figure(section));
    pages.pictures(edges, 3);
}

void add_pairs(pdf::Pages& pages, const std::string& heading,
               const std::vector<std::pair<std::string, std::string>>& pairs) {
    std::vector<std::vector<Cell>> rows;
    for (const auto& [what, text] : pairs)
        rows.push_back({{what}, {text}});
    pages.heading(heading);
    pages.table(std::vector<Column>{{"", 1.0, false}, {"", 5.0, false}}, rows);
}

}  // namespace

core::Result<std::string> report_pdf(const PartResult& part) {
    const std::string name = part.part_name.empty() ? "Unnamed part" : part.part_name;
    const std::string title = name + (part.part_serial.empty() ? "" : " " + part.part_serial);
    const std::string run = part.run_id.empty() ? "" : ", run " + part.run_id;
    auto pages =
        pdf::Pages::make({title + ": " + verdict_word(part),
                          title + run + ". Millimetres unless said, part frame, z along the span.", part.started_utc});
    if (!pages) return tl::unexpected(pages.error());
    pages->title(name, verdict_on_paper(part), ink_of(part.verdict()));
    pages->paragraph(verdict_detail(part), Ink::soft);
    pages->facts(report_facts(part));
    const auto reasons = typeset_reasons(part);
    if (!reasons.empty())
        pages->heading(part.verdict() == Decision::reject ? "Why it is rejected" : "Why it is not accepted");
    for (const auto& reason : reasons)
        pages->paragraph(reason);
    add_results(*pages, part);
    add_characteristics(*pages, part);
    add_budgets(*pages, part);
    std::vector<pdf::Picture> map, trends;
    add(map, "Each section is a strip, cut open at the trailing edge; red: too much material", map_figure(part));
    if (!map.empty()) {
        pages->heading("Deviations over the blade");
        pages->pictures(map, 1);
    }
    if (part.sections.size() > 1) {
        for (const auto& term : report_terms(part))
            add(trends, std::string(term.title), trend_figure(part, term.name));
        pages->heading("Over the height of the blade");
        pages->pictures(trends, 3);
    }
    for (const auto& section : part.sections)
        add_section(*pages, section, part.ball_radius_mm);
    add_pairs(*pages, "Methods", report_methods(part));
    add_pairs(*pages, "Traceability", traceability(part));
    return pages->finish();
}

core::Status export_pdf(const PartResult& part, const std::string& file) {
    const auto bytes = report_pdf(part);
    if (!bytes) return tl::unexpected(bytes.error());
    return core::write_file(file, *bytes);
}

}  // namespace cmm::acquisition
