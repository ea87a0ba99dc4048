// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "acquisition/decision_rule.hpp"
#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

Characteristic not_evaluable(const std::string& name, const std::string& method, std::optional<double> limit,
                             std::string why);
Characteristic reported(const std::string& name, const std::string& method, double value, double u95, std::string note);

/// U95 of a number, and where it comes from, where more than the noise of the points is known. One that rests on what
/// was not measured (more than a thousandth of it) is not evaluable.
void take_uncertainty(const fitting::NumberUncertainty& uncertainty, const fitting::ContourNoise& noise,
                      Characteristic& characteristic);
/// The uncertainty of a deviation at one place, likewise; `scatter_u95_mm` is that by the points.
fitting::ErrorBudget budget_at(const fitting::ContourPoint& place, double scatter_u95_mm, double coverage);

/// Not evaluable: part of what the number rests on, or all of it, was not measured.
void refuse_in_gap(double share, Characteristic& characteristic);
/// Known of a part of its zone only: `share` of it was not measured (0: nothing changes).
void know_gap(double share, Characteristic& characteristic);

/// Holds value and limits against each other by the rule; the guard bands are those of the characteristic, or of its
/// u95 where it has none yet. What is known of a part of its zone only may be rejected, but not accepted. Without
/// limits or without a value nothing changes.
void decide(Characteristic& characteristic, const DecisionRule& rule);

/// "U95 includes 3 um of 2-D offset error"; empty where there is none.
std::string offset_error_note(double error, Unit unit);

}  // namespace cmm::acquisition
