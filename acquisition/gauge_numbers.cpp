// SPDX-License-Identifier: Apache-2.0
#include "acquisition/gauge_numbers.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"

namespace cmm::acquisition {
namespace {

const std::string no_number = "-";

/// Three figures, no more than five decimals.
std::string three_figures(double value) {
    constexpr int most_decimals = 5;
    const double size = std::abs(value);
    const int before = size > 0.0 ? static_cast<int>(std::floor(std::log10(size))) + 1 : 0;
    return core::fixed(value, std::clamp(3 - before, 0, most_decimals));
}

std::string percent(const std::optional<double>& share) {
    return share ? core::fixed(100.0 * *share, 1) : no_number;
}

std::string counted(std::size_t number, const std::string& what) {
    return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

}  // namespace

GaugeScale gauge_scale(Unit unit) {
    switch (unit) {
        case Unit::mm:
            return {"um", core::um_from_mm(1.0)};
        case Unit::rad:
            return {"deg", core::deg_from_rad(1.0)};
        default:
            return {std::string(to_string(unit)), 1.0};
    }
}

std::optional<double> share_of_tolerance(const StudyCharacteristic& one) {
    if (!one.components || !one.tolerance || *one.tolerance <= 0.0) return std::nullopt;
    return one.components->share_of_tolerance(*one.tolerance);
}

std::vector<std::string> gauge_titles() {
    const std::string interval(gauge_interval);
    return {"characteristic", "unit", "trials", "missing",    "EV",  interval,     "AV",  "INT", "GRR",
            interval,         "PV",   "%GRR",   "%tolerance", "ndc", "declared u", "EV/u"};
}

std::vector<std::string> gauge_row(const StudyCharacteristic& one) {
    const auto [unit, factor] = gauge_scale(one.unit);
    const auto number = [scale = factor](const std::optional<double>& value) {
        return value ? three_figures(scale * *value) : no_number;
    };
    const auto size = [&](const std::optional<GaugeComponent>& c) { return c ? number(c->deviation) : no_number; };
    const auto range = [&](const GaugeComponent& c) { return number(c.low) + ".." + number(c.high); };
    std::vector<std::string> row{one.name, unit, one.components ? std::to_string(one.trials) : no_number,
                                 std::to_string(one.missing)};
    if (const auto& found = one.components) {
        const auto categories = found->categories();
        row.insert(row.end(), {size(found->repeatability), range(found->repeatability), size(found->reproducibility),
                               size(found->interacting), size(found->gauge), range(found->gauge),
                               size(found->part_variation), percent(found->share_of_total()),
                               percent(share_of_tolerance(one)), categories ? core::fixed(*categories, 0) : no_number});
    } else {
        row.insert(row.end(), 10, no_number);
    }
    const auto ratio = one.observed_to_declared();
    row.push_back(number(one.declared));
    row.push_back(ratio ? core::fixed(*ratio, 2) : no_number);
    return row;
}

std::string gauge_design(const GaugeStudy& study) {
    std::string names;
    for (const auto& name : study.appraisers)
        names += (names.empty() ? "" : ", ") + name;
    const std::string trials = study.fewest == study.most
                                   ? std::to_string(study.most) + " trials"
                                   : std::to_string(study.fewest) + " to " + std::to_string(study.most) + " trials";
    return counted(study.parts.size(), "part") + ", " + counted(study.appraisers.size(), "appraiser") + " (" + names +
           "), " + trials + ", " + counted(study.runs, "run");
}

std::vector<std::string> gauge_notes(const GaugeStudy& study) {
    std::vector<std::string> notes;
    if (study.appraisers.size() == 1)
        notes.emplace_back(
            "One appraiser: GRR is the repeatability alone; nothing is known about differences between appraisers.");
    if (study.parts.size() == 1)
        notes.emplace_back("One part: its variation is not known, so there is neither %GRR of the total nor ndc.");
    if (study.fewest != study.most)
        notes.emplace_back("Parts were not measured equally often: of each part and appraiser the earliest " +
                           std::to_string(study.fewest) + " runs are used at most.");
    for (const auto& one : study.characteristics) {
        if (!one.components) {
            notes.push_back(one.name + ": not evaluated, " + one.why);
        } else if (one.trials < study.fewest) {
            notes.push_back(one.name + ": not evaluable in " + counted(one.missing, "run") + ", so " +
                            std::to_string(one.trials) + " trials are used and " + counted(one.left_out, "value") +
                            " left out");
        }
    }
    return notes;
}

}  // namespace cmm::acquisition
