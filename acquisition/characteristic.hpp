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

/// Holds value and limits against each other by the rule; the guard bands are those of the characteristic, or of its
/// u95 where it has none yet. Without limits or without a value nothing changes.
void decide(Characteristic& characteristic, const DecisionRule& rule);

/// "U95 includes 3 um of 2-D offset error"; empty where there is none.
std::string offset_error_note(double error, Unit unit);

}  // namespace cmm::acquisition
