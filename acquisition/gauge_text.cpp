// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acquisition/file_number.hpp"
#include "acquisition/gauge_numbers.hpp"
#include "acquisition/gauge_study.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

constexpr int study_csv_digits = 9;

nlohmann::ordered_json json_number(const std::optional<double>& value) {
    return value ? nlohmann::ordered_json(file_number(*value)) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json json_component(const std::optional<GaugeComponent>& component) {
    if (!component) return nullptr;
    return {{"standard", json_number(component->deviation)},
            {"low95", json_number(component->low)},
            {"high95", json_number(component->high)}};
}

nlohmann::ordered_json anova_row(const AnovaRow& row) {
    return {{"squares", row.squares}, {"freedom", row.freedom}};  // squares of micrometres are below a rounded digit
}

nlohmann::ordered_json components_of(const StudyCharacteristic& one) {
    const auto& found = *one.components;
    return {{"repeatability", json_component(found.repeatability)},
            {"reproducibility", json_component(found.reproducibility)},
            {"interaction", json_component(found.interacting)},
            {"gauge", json_component(found.gauge)},
            {"part_variation", json_component(found.part_variation)},
            {"total", json_component(found.total)},
            {"gauge_to_total", json_number(found.share_of_total())},
            {"gauge_to_tolerance", json_number(share_of_tolerance(one))},
            {"distinct_categories", json_number(found.categories())},
            {"interaction_pooled", found.pooled},
            {"interaction_p", json_number(found.interaction_p)},
            {"anova",
             {{"part", anova_row(found.parts)},
              {"appraiser", anova_row(found.appraisers)},
              {"interaction", anova_row(found.interaction)},
              {"repeats", anova_row(found.repeats)}}}};
}

}  // namespace

std::string study_text(const GaugeStudy& study) {
    std::vector<std::vector<std::string>> rows{gauge_titles()};
    for (const auto& one : study.characteristics)
        rows.push_back(gauge_row(one));
    std::vector<std::size_t> widths(rows.front().size(), 0);
    for (const auto& row : rows)
        for (std::size_t i = 0; i < row.size(); ++i)
            widths[i] = std::max(widths[i], row[i].size());
    std::string out = "gauge study of " + study.part_name + ": " + gauge_design(study) + "\n\n";
    for (const auto& row : rows) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string space(widths[i] - row[i].size(), ' ');
            line += (i == 0 ? "" : "  ") + (i == 0 ? row[i] + space : space + row[i]);
        }
        out += line + '\n';
    }
    out += '\n';
    for (const auto& note : gauge_notes(study))
        out += note + '\n';
    return out;
}

std::string study_csv(const GaugeStudy& study) {
    std::string out =
        "name,unit,trials,missing,left_out,ev,ev_low95,ev_high95,av,av_low95,av_high95,interaction,interaction_low95,"
        "interaction_high95,grr,grr_low95,grr_high95,pv,pv_low95,pv_high95,tv,tv_low95,tv_high95,grr_to_total,grr_to_"
        "tolerance,categories,interaction_p,pooled,declared\n";
    for (const auto& one : study.characteristics) {
        const bool angle = one.unit == Unit::rad;
        const auto plain = [](const std::optional<double>& value) {
            return value ? "," + core::fixed(*value, study_csv_digits) : std::string(",");
        };
        const auto cell = [&](const std::optional<double>& value) {
            return plain(value && angle ? std::optional(core::deg_from_rad(*value)) : value);
        };
        const auto component = [&](const std::optional<GaugeComponent>& c) {
            return c ? cell(c->deviation) + cell(c->low) + cell(c->high) : std::string(",,,");
        };
        out += one.name + ',' + (angle ? "deg" : std::string(to_string(one.unit))) + ',' + std::to_string(one.trials) +
               ',' + std::to_string(one.missing) + ',' + std::to_string(one.left_out);
        if (const auto& found = one.components) {
            for (const auto& c : {std::optional(found->repeatability), found->reproducibility, found->interacting,
                                  std::optional(found->gauge), found->part_variation, found->total})
                out += component(c);
            out += plain(found->share_of_total()) + plain(share_of_tolerance(one)) + plain(found->categories()) +
                   plain(found->interaction_p) + (found->pooled ? ",1" : ",0");
        } else {
            out += std::string(23, ',');
        }
        out += cell(one.declared) + '\n';
    }
    return out;
}

std::string study_json(const GaugeStudy& study) {
    using Json = nlohmann::ordered_json;
    Json characteristics = Json::array();
    for (const auto& one : study.characteristics) {
        Json values = Json::array();
        for (const auto& [part, appraiser, value] : one.values)
            values.push_back(Json::array({part, appraiser, file_number(value)}));
        characteristics.push_back({{"name", one.name},
                                   {"method", one.method},
                                   {"unit", to_string(one.unit)},
                                   {"tolerance", json_number(one.tolerance)},
                                   {"trials", one.trials},
                                   {"missing", one.missing},
                                   {"left_out", one.left_out},
                                   {"why", one.why},
                                   {"declared_standard", json_number(one.declared)},
                                   {"observed_to_declared", json_number(one.observed_to_declared())}});
        characteristics.back()["components"] = one.components ? components_of(one) : Json(nullptr);
        characteristics.back()["values"] = std::move(values);
    }
    const Json out{{"schema", "cmmlive-study"},    {"schema_version", 1},
                   {"part_name", study.part_name}, {"runs", study.runs},
                   {"parts", study.parts},         {"appraisers", study.appraisers},
                   {"notes", gauge_notes(study)},  {"characteristics", std::move(characteristics)}};
    return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace cmm::acquisition
