// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/linuxcnc_settings.hpp"

#include <algorithm>
#include <cctype>
#include <string_view>

namespace cmm::drivers::linuxcnc {
namespace {

constexpr double most_joints = 9.0;
constexpr double largest_number = 1e9;

/// Three numbers, or nothing where the key is absent.
std::optional<Eigen::Vector3d> read_corner(const core::ConfigTable& table, std::string_view key) {
    if (!table.has(key)) return std::nullopt;
    const auto values = table.numbers(key);
    if (values.size() == 3) return Eigen::Vector3d(values[0], values[1], values[2]);
    table.complain(key, "needs three numbers: x, y, z");
    return std::nullopt;
}

/// linuxcncrsh takes words apart at blanks.
std::string read_password(const core::ConfigTable& table, std::string_view key, std::string_view fallback) {
    const std::string word = table.text(key, fallback);
    const bool whole =
        !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isgraph(c) != 0; });
    if (!whole) table.complain(key, "must be one word");
    return word;
}

}  // namespace

LinuxcncSettings read_linuxcnc_settings(const core::ConfigTable& table) {
    LinuxcncSettings settings;
    settings.connect_password = read_password(table, "connect_password", settings.connect_password);
    settings.enable_password = read_password(table, "enable_password", settings.enable_password);
    settings.joints = static_cast<std::size_t>(table.integer("joints", 3, {1.0, most_joints}));
    settings.reset_estop = table.boolean("reset_estop", settings.reset_estop);
    settings.limit_min_mm = read_corner(table, "limit_min_mm");
    settings.limit_max_mm = read_corner(table, "limit_max_mm");
    if (settings.limit_min_mm.has_value() != settings.limit_max_mm.has_value()) {
        table.complain(settings.limit_min_mm ? "limit_min_mm" : "limit_max_mm",
                       "limit_min_mm and limit_max_mm go together");
    } else if (settings.limit_min_mm && (*settings.limit_max_mm - *settings.limit_min_mm).minCoeff() <= 0.0) {
        table.complain("limit_max_mm", "must be larger than limit_min_mm on every axis");
    }
    settings.max_speed_mm_s = table.number("max_speed_mm_s", 0.0, {0.0, largest_number});
    settings.max_acceleration_mm_s2 = table.number("max_acceleration_mm_s2", 0.0, {0.0, largest_number});
    settings.latch_delay_us = table.number("latch_delay_us", settings.latch_delay_us, {0.0, 100'000.0});
    settings.home_patience_s = table.number("home_patience_s", settings.home_patience_s, {0.1, 3600.0});
    return settings;
}

}  // namespace cmm::drivers::linuxcnc
