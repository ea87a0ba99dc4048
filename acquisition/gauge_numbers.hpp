// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/gauge_study.hpp"

/// The numbers of a study as people read them, the same in every table.
namespace cmm::acquisition {

/// "um", "deg", "mm2", "1", and how many of them the unit of the values is.
struct GaugeScale {
    std::string unit;
    double factor = 1.0;
};
GaugeScale gauge_scale(Unit unit);

/// Of a tolerance with a width.
std::optional<double> share_of_tolerance(const StudyCharacteristic& one);

/// Columns of the table, and a row: three figures of each standard deviation, shares in percent, "-" for what is none.
inline constexpr std::string_view gauge_interval = "95 %";  ///< title of a column that belongs to the one before it
std::vector<std::string> gauge_titles();
std::vector<std::string> gauge_row(const StudyCharacteristic& one);
/// "10 parts, 3 appraisers (A, B, C), 3 trials, 90 runs".
std::string gauge_design(const GaugeStudy& study);
/// What a reader has to know beside the table, a sentence each: one appraiser or part, what was not evaluated and why.
std::vector<std::string> gauge_notes(const GaugeStudy& study);

}  // namespace cmm::acquisition
