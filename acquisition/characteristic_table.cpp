// SPDX-License-Identifier: Apache-2.0
#include "acquisition/characteristic_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "acquisition/svg.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

using svg::escape;

constexpr std::array always{"profile_le", "profile_suction", "profile_te", "profile_pressure",
                            "le_radius",  "te_radius",       "chord",      "max_thickness"};

/// One of those that are always there belongs to this table when the part file gave it a nominal or limits.
bool was_asked_for(const Characteristic& c) {
    const bool known = std::find(always.begin(), always.end(), c.name) != always.end();
    return !known || c.nominal || c.lower;
}

const std::string whole_part = "part";

std::string number(const std::optional<double>& value, Unit unit) {
    if (!value) return {};
    const int digits = unit == Unit::share || unit == Unit::per_mm ? 5 : unit == Unit::count ? 0 : 4;
    return core::fixed(unit == Unit::rad ? core::deg_from_rad(*value) : *value, digits);
}

const char* symbol(Unit unit) {
    return unit == Unit::mm       ? "mm"
           : unit == Unit::rad    ? "\u00b0"
           : unit == Unit::mm2    ? "mm\u00b2"
           : unit == Unit::per_mm ? "1/mm"
                                  : "";
}

CharacteristicRow row_of(const std::string& place, const Characteristic& c) {
    const std::string deviation = c.value && c.nominal ? number(*c.value - *c.nominal, c.unit) : std::string();
    return {place,
            c.name,
            symbol(c.unit),
            number(c.value, c.unit),
            number(c.u95, c.unit),
            number(c.nominal, c.unit),
            deviation,
            number(c.lower, c.unit),
            number(c.upper, c.unit),
            c.decision,
            !c.value         ? c.note
            : c.note.empty() ? c.method
                             : c.method + "; " + c.note};
}

std::string html_of(const CharacteristicRow& row) {
    const std::string css(to_string(row.decision));
    std::string decision = css;
    std::replace(decision.begin(), decision.end(), '_', ' ');
    const std::string place =
        row.section == whole_part ? row.section : "<a href=\"#section-" + row.section + "\">" + row.section + "</a>";
    std::string out =
        "<tr><td>" + place + "</td><td class=\"word\">" + escape(row.name) + "</td><td>" + row.unit + "</td>";
    out += row.value.empty() ? "<td class=\"not_evaluable\">n/e</td>" : "<td>" + row.value + "</td>";
    for (const auto* number : {&row.u95, &row.nominal, &row.deviation, &row.lower, &row.upper})
        out += "<td>" + *number + "</td>";
    return out + "<td class=\"word " + css + "\">" + decision +
           "</td><td class=\"word\" style=\"white-space:normal;min-width:15em\">" + escape(row.method) + "</td></tr>\n";
}

}  // namespace

std::vector<CharacteristicRow> asked_rows(const PartResult& part) {
    std::vector<CharacteristicRow> rows;
    for (const auto& [c, section] : part.characteristics)
        rows.push_back(row_of(section ? std::to_string(*section) : whole_part, c));
    for (const auto& section : part.sections)
        for (const auto& c : section.characteristics)
            if (was_asked_for(c)) rows.push_back(row_of(std::to_string(section.index), c));
    return rows;
}

std::string characteristic_table(const PartResult& part) {
    std::string rows;
    for (const auto& row : asked_rows(part))
        rows += html_of(row);
    if (rows.empty()) return {};
    return "<h2>Characteristics</h2>\n<div class=\"sheet wide\"><table><thead><tr><th>Section</th><th "
           "class=\"word\">Characteristic</th><th></th><th>Value</th><th>U95</th><th>Nominal</th><th>Deviation</th>"
           "<th>Lower limit</th><th>Upper limit</th><th class=\"word\">Decision</th><th class=\"word\">Method, or why "
           "it "
           "is not evaluable</th></tr></thead>\n<tbody>" +
           rows + "</tbody></table></div>\n";
}

}  // namespace cmm::acquisition
