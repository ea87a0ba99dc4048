// SPDX-License-Identifier: Apache-2.0
#include "acquisition/uncertainty_spec.hpp"

#include <array>
#include <cmath>

#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ConfigTable;

constexpr double reference_c = 20.0;  // ISO 1
constexpr std::array<std::string_view, 3> correction_names{"none", "applied", "by_machine"};
constexpr double per_k_from_um_m_k = 1e-6;
const double rectangular = std::sqrt(3.0);

void read_temperature(const ConfigTable& table, UncertaintySpec& spec) {
    spec.part_temperature_c = table.number("part_temperature_c", reference_c, {-20.0, 80.0});
    spec.temperature_standard_k = table.number("temperature_standard_k", 0.0, {0.0, 20.0});
    spec.expansion_per_k = per_k_from_um_m_k * table.number("expansion_um_m_k", 0.0, {-5.0, 100.0});
    spec.expansion_standard_per_k = per_k_from_um_m_k * table.number("expansion_standard_um_m_k", 0.0, {0.0, 50.0});
    const std::string name = table.word("expansion_correction", correction_names.front(),
                                        {correction_names.begin(), correction_names.end()});
    for (std::size_t k = 0; k < correction_names.size(); ++k)
        if (correction_names[k] == name) spec.correction = static_cast<ExpansionCorrection>(k);
    const bool temperature = table.has("part_temperature_c") || table.has("temperature_standard_k");
    if (temperature && !table.has("expansion_um_m_k"))
        table.complain("expansion_um_m_k", "is missing: a temperature says nothing without the part's expansion");
    for (const char* key : {"expansion_um_m_k", "expansion_standard_um_m_k"})
        if (table.has(key) && !temperature)
            table.complain(key, "needs part_temperature_c, or temperature_standard_k for a part at 20 degrees");
    if (spec.correction != ExpansionCorrection::none && !table.has("part_temperature_c"))
        table.complain("expansion_correction", "needs part_temperature_c");
}

void read_fixed_at(const ConfigTable& table, UncertaintySpec& spec) {
    const auto values = table.numbers("fixed_at_mm");
    if (!table.has("fixed_at_mm")) return;
    if (values.size() == 3)
        spec.fixed_at_mm = {values[0], values[1], values[2]};
    else
        table.complain("fixed_at_mm", "must be three numbers [x, y, z] in mm");
}

void append(std::string& words, const std::string& more) {
    words += (words.empty() ? "" : "; ") + more;
}

std::string temperature_words(const UncertaintySpec& spec) {
    std::string words = "part at " + core::fixed(spec.part_temperature_c, 2) + " C (u " +
                        core::fixed(spec.temperature_standard_k, 2) + " K), " +
                        core::fixed(spec.expansion_per_k / per_k_from_um_m_k, 1) + " um/(m K) (u " +
                        core::fixed(spec.expansion_standard_per_k / per_k_from_um_m_k, 1) + ")";
    if (spec.part_temperature_c == reference_c) return words;
    switch (spec.correction) {
        case ExpansionCorrection::none:
            return words + ", not corrected";
        case ExpansionCorrection::applied:
            return words + ", corrected to 20 C";
        case ExpansionCorrection::by_machine:
            return words + ", corrected by the machine";
    }
    return words;
}

}  // namespace

std::string_view to_string(ExpansionCorrection correction) noexcept {
    return correction_names[static_cast<std::size_t>(correction)];
}

double UncertaintySpec::growth() const {
    return expansion_per_k * (part_temperature_c - reference_c);
}

fitting::SystematicErrors UncertaintySpec::errors() const {
    const auto known = figures();
    const auto standard = [](const std::optional<double>& largest) { return largest.value_or(0.0) / rectangular; };
    fitting::SystematicErrors out;
    // Of a diameter and of a range half is that of a radius, and of a distance from the mean.
    out.ball_mm = std::hypot(known.ball_standard_mm.value_or(0.0), 0.5 * standard(known.probing_size_mm));
    out.form_mm = 0.5 * standard(known.probing_form_mm);
    out.constant_mm = standard(known.length_mm);
    out.per_mm = standard(known.length_share);
    out.expansion = std::hypot(expansion_per_k * temperature_standard_k,
                               (part_temperature_c - reference_c) * expansion_standard_per_k);
    if (correction == ExpansionCorrection::none) out.known_expansion = growth();
    out.fixed_at_mm = fixed_at_mm;
    return out;
}

UncertaintySpec read_uncertainty(const ConfigTable& table) {
    UncertaintySpec spec;
    spec.stated = drivers::read_machine_errors(table);
    read_temperature(table, spec);
    read_fixed_at(table, spec);
    return spec;
}

std::string uncertainty_words(const UncertaintySpec& spec) {
    const auto figures = spec.figures();
    std::string words;
    if (figures.length_mm || figures.length_share) {
        std::string length = "E0 " + core::length_text(figures.length_mm.value_or(0.0));
        if (figures.length_share && *figures.length_share > 0.0)
            length += " + L/" + core::fixed(1e-3 / *figures.length_share, 0) + " mm/um";
        append(words, length);
    }
    if (figures.probing_form_mm) append(words, "P_Form " + core::length_text(*figures.probing_form_mm));
    if (figures.probing_size_mm) append(words, "P_Size " + core::length_text(*figures.probing_size_mm));
    if (figures.ball_standard_mm) append(words, "ball radius u " + core::length_text(*figures.ball_standard_mm));
    if (spec.expansion_per_k != 0.0 || spec.expansion_standard_per_k != 0.0) append(words, temperature_words(spec));
    return words;
}

}  // namespace cmm::acquisition
