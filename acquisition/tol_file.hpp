// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acquisition/characteristic_spec.hpp"
#include "core/error.hpp"

namespace cmm::acquisition {

/// What a line of a tolerance file says.
enum class TolWord : std::uint8_t {
    le_offset,  ///< distance of LETHCK, from the end of the camber line
    te_offset,
    le_angle_offsets,  ///< the two distances of LEANGLE
    te_angle_offsets,
    le_change,  ///< how far LE reaches for the profiles after the best fit
    te_change,
    root_section,
    tip_section,
    reference_section,  ///< of RELTWIST
    exclude,            ///< zones that take no part in the best fit
    calculation,        ///< a characteristic with its tolerance
};

/// A line, in millimetres and radians.
struct TolEntry {
    TolWord word = TolWord::calculation;
    std::string place;                       ///< "file:line:column: ", for messages
    std::string keyword;                     ///< in capitals, as it stands: LETHCK2
    std::size_t which = 1;                   ///< 2 to 10 of LE_OFFSET2, LETHCK10
    std::optional<CharacteristicKind> kind;  ///< of a calculation
    std::vector<double> numbers;             ///< of offsets; of a calculation: upper, lower
    bool are_limits = false;                 ///< of a calculation: upper and lower are limits, not deviations
    std::optional<double> nominal;           ///< of a calculation
    std::string section;                     ///< that the word names
    ZoneSet fit_zones = all_zones;           ///< of exclude: those that are left
    bool of_all = true;                      ///< it stands before the first SECTION
};

/// The lines that hold for one section, or for all of them.
struct TolBlock {
    std::string section;  ///< empty: for all sections
    std::string place;
    std::vector<TolEntry> entries;
};

struct TolFile {
    std::string place;  ///< of the number of sections
    std::optional<std::size_t> sections;
    std::vector<TolBlock> blocks;  ///< the first is for all sections
};

/// Reads a tolerance file of PC-DMIS Blade (.TOL; Hexagon, PC-DMIS Blade 6.0 help, "Tolerance File Keywords";
/// docs/part-file.md says how it is understood). `inches`: of the nominal file, where the file has no UNITS. A keyword
/// that we do not evaluate is an error unless `skip` names it, so that no tolerance is lost unseen. Errors:
/// input_invalid with file:line:column.
core::Result<TolFile> parse_tol(std::string_view content, const std::string& name, std::span<const std::string> skip,
                                bool inches);

}  // namespace cmm::acquisition
