// SPDX-License-Identifier: Apache-2.0
#include "acquisition/characteristic.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.hpp"

namespace cmm::acquisition {

Characteristic not_evaluable(const std::string& name, const std::string& method, std::optional<double> limit,
                             std::string why) {
    return {name, method, {}, {}, limit, Decision::not_evaluable, std::move(why)};
}

Characteristic reported(const std::string& name, const std::string& method, double value, double u95,
                        std::string note) {
    return {name, method, value, u95, {}, Decision::reported, std::move(note)};
}

std::string offset_error_note(double error, Unit unit) {
    if (!(error > 0.0)) return {};
    const std::string size = unit == Unit::mm ? core::length_text(error) : worded(error, unit);
    return "U95 includes " + size + " of 2-D offset error";
}

void take_uncertainty(const fitting::NumberUncertainty& uncertainty, const fitting::ContourNoise& noise,
                      Characteristic& c) {
    c.u95 = uncertainty.u95;
    if (noise.has_fields()) c.budget = uncertainty.budget;
}

fitting::ErrorBudget budget_at(const fitting::ContourPoint& place, double scatter_u95_mm, double coverage) {
    const double added = place.bound_mm + place.offset_error_mm;
    return {std::max(0.0, scatter_u95_mm - added) / coverage, place.machine.standard_mm,
            added + std::abs(place.machine.known_mm)};
}

void decide(Characteristic& c, const DecisionRule& rule) {
    if (!c.has_limits() || !c.value || !c.u95) return;
    if (!c.guard_accept || !c.guard_reject) {
        const auto [accept, reject] = rule.guards(*c.u95);
        c.guard_accept = accept;
        c.guard_reject = reject;
    }
    c.decision = rule.decide(*c.value, {*c.guard_accept, *c.guard_reject}, c.lower, c.upper);
}

}  // namespace cmm::acquisition
