// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cmm::acquisition {

/// What the number of a characteristic counts. Angles are radians here and degrees in texts and tables.
enum class Unit : std::uint8_t { mm, rad, mm2, per_mm, share, count };
/// "mm", "rad", "mm2", "1/mm", and of shares and counts "1".
std::string_view to_string(Unit unit) noexcept;
/// Of keys and columns that hold such a number as people read it: "_mm", "_deg", "_mm2", "_per_mm", "".
std::string_view column_suffix(Unit unit) noexcept;
/// For people: "0.212 mm", "24.0012 deg".
std::string worded(double value, Unit unit);

}  // namespace cmm::acquisition
