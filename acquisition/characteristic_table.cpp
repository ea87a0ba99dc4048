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

std::string number(const std::optional<double>& value, Unit unit) {
    if (!value) return "<td></td>";
    const bool angle = unit == Unit::rad;
    const int digits = unit == Unit::share ? 5 : 4;
    return "<td>" + core::fixed(angle ? core::deg_from_rad(*value) : *value, digits) + "</td>";
}

const char* symbol(Unit unit) {
    return unit == Unit::mm ? "mm" : unit == Unit::rad ? "\u00b0" : unit == Unit::mm2 ? "mm\u00b2" : "";
}

std::string row(const std::string& place, const Characteristic& c) {
    const auto deviation = c.value && c.nominal ? std::optional(*c.value - *c.nominal) : std::nullopt;
    std::string decision(to_string(c.decision));
    const std::string css = decision;
    std::replace(decision.begin(), decision.end(), '_', ' ');
    std::string out = "<tr><td>" + place + "</td><td class=\"word\" title=\"" + escape(c.method) + "\">" +
                      escape(c.name) + "</td><td>" + symbol(c.unit) + "</td>";
    out += c.value ? number(c.value, c.unit) : "<td class=\"not_evaluable\">n/e</td>";
    out += number(c.u95, c.unit) + number(c.nominal, c.unit) + number(deviation, c.unit) + number(c.lower, c.unit) +
           number(c.upper, c.unit);
    out += "<td class=\"word " + css + "\">" + decision +
           "</td><td class=\"word\" style=\"white-space:normal;min-width:15em\">" +
           escape(c.value ? c.method : c.note) + "</td></tr>\n";
    return out;
}

}  // namespace

std::string characteristic_table(const PartResult& part) {
    const auto link = [](std::size_t index) {
        return "<a href=\"#section-" + std::to_string(index) + "\">" + std::to_string(index) + "</a>";
    };
    std::string rows;
    for (const auto& [c, section] : part.characteristics)
        rows += row(section ? link(*section) : "part", c);
    for (const auto& section : part.sections)
        for (const auto& c : section.characteristics)
            if (was_asked_for(c)) rows += row(link(section.index), c);
    if (rows.empty()) return {};
    return "<h2>Characteristics</h2>\n<div class=\"sheet wide\"><table><thead><tr><th>Section</th><th "
           "class=\"word\">Characteristic</th><th></th><th>Value</th><th>U95</th><th>Nominal</th><th>Deviation</th>"
           "<th>Lower limit</th><th>Upper limit</th><th class=\"word\">Decision</th><th class=\"word\">Method, or why "
           "it "
           "is not evaluable</th></tr></thead>\n<tbody>" +
           rows + "</tbody></table></div>\n";
}

}  // namespace cmm::acquisition
