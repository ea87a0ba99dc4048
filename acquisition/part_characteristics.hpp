// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "acquisition/characteristic_spec.hpp"
#include "acquisition/decision_rule.hpp"
#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// Adds the asked characteristics that need several sections (is_of_part) to a part whose sections are all judged.
/// Root and tip are its lowest and highest section unless `asked` says others. Where one of the sections that a number
/// needs was not measured or lies nowhere on its nominal, that number is not evaluable and says why. Errors of
/// different sections are independent; what an alignment of the whole blade does to all of them alike cancels.
/// Definitions: docs/theory.md, section 15.
void add_part_characteristics(const std::vector<CharacteristicSpec>& asked, const DecisionRule& rule, PartResult& part);

}  // namespace cmm::acquisition
