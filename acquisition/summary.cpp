// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "acquisition/exports.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using Row = std::vector<std::string>;

constexpr int table_digits = 3;

/// The worse of two profile characteristics: by its share of the limit, or by its value where there is none.
const Characteristic* worse(const SectionResult& section, const char* one, const char* other) {
    const auto* a = section.find(one);
    const auto* b = section.find(other);
    if (a == nullptr || b == nullptr) return a != nullptr ? a : b;
    return b->value.value_or(-1.0) > a->value.value_or(-1.0) ? b : a;
}

std::string value_cell(const Characteristic* c) {
    if (c == nullptr || !c->value) return "-";
    return core::fixed(*c->value, table_digits) + (c->decision == Decision::reject ? " !" : "");
}

std::string limit_of(const PartResult& part, const char* name) {
    for (const auto& section : part.sections) {
        const auto* c = section.find(name);
        if (c != nullptr && c->upper) return " <= " + core::fixed(*c->upper, table_digits);
    }
    return {};
}

Row row_of(const SectionResult& section) {
    return {std::to_string(section.index),
            core::fixed(section.z_mm, 2),
            std::to_string(section.points.size()),
            std::to_string(section.rejected()),
            value_cell(worse(section, "profile_suction", "profile_pressure")),
            value_cell(worse(section, "profile_le", "profile_te")),
            value_cell(section.find("le_radius")),
            value_cell(section.find("te_radius")),
            std::string(section.has_contour() || section.decision() == Decision::reject ? to_string(section.decision())
                                                                                        : "not evaluable")};
}

void append_row(std::string& out, const Row& row, const std::vector<std::size_t>& widths) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
        const std::string space(widths[i] - row[i].size(), ' ');
        const bool words = i + 1 == row.size();
        line += (i == 0 ? "" : "  ") + (words ? row[i] : space + row[i]);
    }
    out += line + '\n';
}

}  // namespace

std::string verdict_word(const PartResult& part) {
    const auto verdict = part.verdict();
    return verdict == Decision::accept && !part.has_requirements() ? "done" : std::string(to_string(verdict));
}

std::string summary_text(const PartResult& part) {
    std::vector<Row> rows{{"section", "z mm", "points", "rejected", "sides mm" + limit_of(part, "profile_suction"),
                           "edges mm" + limit_of(part, "profile_le"), "LE radius mm", "TE radius mm", "decision"}};
    for (const auto& section : part.sections)
        rows.push_back(row_of(section));
    std::vector<std::size_t> widths(rows.front().size(), 0);
    for (const auto& row : rows) {
        for (std::size_t i = 0; i < row.size(); ++i)
            widths[i] = std::max(widths[i], row[i].size());
    }
    std::string out;
    for (const auto& row : rows)
        append_row(out, row, widths);
    std::string word = verdict_word(part);
    std::transform(word.begin(), word.end(), word.begin(),
                   [](char c) { return c >= 'a' && c <= 'z' ? char(c - 32) : c; });
    out += "\nverdict: " + word + '\n';
    for (const auto& reason : verdict_reasons(part))
        out += "  " + reason + '\n';
    return out;
}

}  // namespace cmm::acquisition
