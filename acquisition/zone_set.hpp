// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "core/config.hpp"

namespace cmm::acquisition {

/// Zones of a section, by fitting::Zone.
using ZoneSet = std::array<bool, 4>;
inline constexpr ZoneSet all_zones{true, true, true, true};

/// A list of le, suction, te, pressure; all of them where the key is absent. Complains of other words and of none.
ZoneSet read_zone_set(const core::ConfigTable& table, std::string_view key);
/// "le suction"; of all zones nothing.
std::string zone_words(const ZoneSet& zones);

}  // namespace cmm::acquisition
