// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "acquisition/section_result.hpp"

/// Where the uncertainties come from, for those who read a report.
namespace cmm::acquisition {

/// The parts of a budget in the order in which they are shown: noise, ball, probing, length, temperature, added.
inline constexpr std::size_t budget_parts = fitting::error_sources + 2;
struct BudgetPart {
    const char* key;    ///< in files
    const char* title;  ///< for people
};
inline constexpr std::array<BudgetPart, budget_parts> budget_words{{{"noise", "Noise of the points"},
                                                                    {"ball", "Ball radius"},
                                                                    {"probing", "Probing"},
                                                                    {"length", "Length"},
                                                                    {"temperature", "Temperature"},
                                                                    {"added", "Added as it is"}}};
std::array<double, budget_parts> parts_of(const fitting::ErrorBudget& budget);

/// A line of the table, numbers as texts: lengths in micrometres, angles in thousandths of a degree.
struct BudgetRow {
    std::string name, section, unit;
    std::array<std::string, budget_parts> parts;
    std::size_t largest = 0;  ///< of the parts
    std::string u95;
};
/// Of each characteristic of the sections the one with the largest U95, and those of the part. Empty where nothing is
/// known but the noise of the points.
std::vector<BudgetRow> budget_rows(const PartResult& part);
/// What the numbers are, in words.
std::string budget_note();
/// Of the report.
std::string budget_table(const PartResult& part);

}  // namespace cmm::acquisition
