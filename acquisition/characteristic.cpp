// SPDX-License-Identifier: Apache-2.0
#include "acquisition/characteristic.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

constexpr double most_in_gaps = 0.001;  // of what a number rests on

}  // namespace

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

void refuse_in_gap(double share, Characteristic& c) {
    c.value.reset();
    c.u95.reset();
    c.budget.reset();
    c.decision = Decision::not_evaluable;
    c.note = core::fixed(100.0 * share, 1) + " % of what it rests on was not measured: a gap of the points";
}

void know_gap(double share, Characteristic& c) {
    if (!(share > 0.0)) return;
    c.partly = true;
    c.note += (c.note.empty() ? "" : "; ") + core::fixed(100.0 * share, 1) + " % of it was not measured";
}

void take_uncertainty(const fitting::NumberUncertainty& uncertainty, const fitting::ContourNoise& noise,
                      Characteristic& c) {
    if (uncertainty.in_gaps > most_in_gaps) return refuse_in_gap(uncertainty.in_gaps, c);
    c.u95 = uncertainty.u95;
    if (noise.has_fields()) c.budget = uncertainty.budget;
}

fitting::ErrorBudget budget_at(const fitting::ContourPoint& place, double scatter_u95_mm, double coverage) {
    const double added = place.bound_mm + place.offset_error_mm;
    return {std::max(0.0, scatter_u95_mm - added) / coverage, place.machine.standard_mm,
            added + place.flattened_mm + std::abs(place.machine.known_mm)};
}

void decide(Characteristic& c, const DecisionRule& rule) {
    if (!c.has_limits() || !c.value || !c.u95) return;
    if (!c.guard_accept || !c.guard_reject) {
        const auto [accept, reject] = rule.guards(*c.u95);
        c.guard_accept = accept;
        c.guard_reject = reject;
    }
    c.decision = rule.decide(*c.value, {*c.guard_accept, *c.guard_reject}, c.lower, c.upper);
    if (c.partly && c.decision == Decision::accept) c.decision = Decision::undecided;
}

}  // namespace cmm::acquisition
