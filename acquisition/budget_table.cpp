// SPDX-License-Identifier: Apache-2.0
#include "acquisition/budget_table.hpp"

#include <algorithm>
#include <cmath>

#include "acquisition/svg.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

/// How a number of a unit is shown where it is an uncertainty.
struct Shown {
    const char* unit;
    double factor;
    int digits;
};

Shown shown_as(Unit unit) {
    switch (unit) {
        case Unit::mm:
            return {"\u00b5m", core::um_from_mm(1.0), 2};
        case Unit::rad:
            return {"0.001\u00b0", 1e3 * core::deg_from_rad(1.0), 2};
        case Unit::mm2:
            return {"mm\u00b2", 1.0, 4};
        case Unit::per_mm:
            return {"1/mm", 1.0, 5};
        case Unit::share:
        case Unit::count:
            break;
    }
    return {"", 1.0, 6};
}

BudgetRow budget_row(const Characteristic& c, std::string section) {
    const Shown shown = shown_as(c.unit);
    const auto text = [&](double value) { return core::fixed(shown.factor * value, shown.digits); };
    BudgetRow row;
    row.name = c.name;
    row.section = std::move(section);
    row.unit = shown.unit;
    const auto parts = parts_of(*c.budget);
    std::transform(parts.begin(), parts.end(), row.parts.begin(), text);
    row.largest = static_cast<std::size_t>(std::max_element(parts.begin(), parts.end()) - parts.begin());
    row.u95 = text(c.u95.value_or(0.0));
    return row;
}

}  // namespace

std::array<double, budget_parts> parts_of(const fitting::ErrorBudget& budget) {
    std::array<double, budget_parts> parts{};
    parts.front() = budget.noise;
    std::copy(budget.machine.begin(), budget.machine.end(), parts.begin() + 1);
    parts.back() = budget.bound;
    return parts;
}

std::vector<BudgetRow> budget_rows(const PartResult& part) {
    struct Worst {
        const Characteristic* c;
        std::size_t section;
    };
    std::vector<Worst> worst;
    for (const auto& section : part.sections) {
        for (const auto& c : section.characteristics) {
            if (!c.budget || !c.u95) continue;
            const auto same =
                std::find_if(worst.begin(), worst.end(), [&](const Worst& known) { return known.c->name == c.name; });
            if (same == worst.end())
                worst.push_back({&c, section.index});
            else if (*c.u95 > *same->c->u95)
                *same = {&c, section.index};
        }
    }
    std::vector<BudgetRow> rows;
    for (const auto& [c, section] : worst)
        rows.push_back(budget_row(*c, std::to_string(section)));
    for (const auto& c : part.characteristics) {
        if (!c.number.budget) continue;
        rows.push_back(budget_row(c.number, c.section ? std::to_string(*c.section) : "part"));
    }
    return rows;
}

std::string budget_note() {
    return "Standard uncertainties, of each characteristic in the section with the largest U95. U95 is twice the root "
           "of "
           "the sum of their squares, plus what is added as it is; of profiles it is larger, as the worst of many "
           "places "
           "counts.";
}

std::string budget_table(const PartResult& part) {
    std::string rows;
    for (const auto& row : budget_rows(part)) {
        rows += "<tr><td class=\"word\">" + svg::escape(row.name) + "</td><td>" + row.section + "</td><td>" + row.unit +
                "</td>";
        for (std::size_t k = 0; k < row.parts.size(); ++k)
            rows += k == row.largest ? "<td><b>" + row.parts[k] + "</b></td>" : "<td>" + row.parts[k] + "</td>";
        rows += "<td>" + row.u95 + "</td></tr>\n";
    }
    if (rows.empty()) return {};
    std::string head;
    for (const auto& word : budget_words)
        head += "<th>" + std::string(word.title) + "</th>";
    return "<h2>Where the uncertainties come from</h2>\n<div class=\"sheet wide\"><p>" + budget_note() +
           " The largest part is bold.</p>\n<table><thead><tr><th class=\"word\">Characteristic</th><th>Section</th>"
           "<th></th>" +
           head + "<th>U95</th></tr></thead>\n<tbody>" + rows + "</tbody></table></div>\n";
}

}  // namespace cmm::acquisition
