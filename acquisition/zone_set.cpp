// SPDX-License-Identifier: Apache-2.0
#include "acquisition/zone_set.hpp"

#include <algorithm>

namespace cmm::acquisition {
namespace {

constexpr std::array<std::string_view, 4> zone_names{"le", "suction", "te", "pressure"};  // by fitting::Zone

}  // namespace

ZoneSet read_zone_set(const core::ConfigTable& table, std::string_view key) {
    if (!table.has(key)) return all_zones;
    ZoneSet zones{};
    for (const auto& name : table.texts(key)) {
        const auto known = std::find(zone_names.begin(), zone_names.end(), name);
        if (known != zone_names.end())
            zones[static_cast<std::size_t>(known - zone_names.begin())] = true;
        else
            table.complain(key, "holds \"" + name + "\", which is none of le, suction, te, pressure");
    }
    if (zones == ZoneSet{}) table.complain(key, "must hold one of le, suction, te, pressure");
    return zones;
}

std::string zone_words(const ZoneSet& zones) {
    std::string words;
    if (zones == all_zones) return words;
    for (std::size_t k = 0; k < zone_names.size(); ++k)
        if (zones[k]) words += (words.empty() ? "" : " ") + std::string(zone_names[k]);
    return words;
}

}  // namespace cmm::acquisition
