// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "acquisition/section_result.hpp"

namespace cmm::acquisition {

/// A line of the table, numbers as texts: angles in degrees; empty where there is none.
struct CharacteristicRow {
    std::string section, name, unit, value, u95, nominal, deviation, lower, upper;
    Decision decision = Decision::reported;
    std::string method;  ///< with what is to be said of the value; or why it is not evaluable
};
/// Every characteristic that the part file asked for: of the part, then section by section.
std::vector<CharacteristicRow> asked_rows(const PartResult& part);

/// Of the report: every characteristic that the part file asked for, with method, value, U95, nominal, deviation,
/// limits and decision, section by section. Empty where nothing was asked for.
std::string characteristic_table(const PartResult& part);

}  // namespace cmm::acquisition
