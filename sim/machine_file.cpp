// SPDX-License-Identifier: Apache-2.0
#include "sim/machine_file.hpp"

#include "core/config.hpp"

namespace cmm::sim {
namespace {

void read_axes(const core::ConfigTable& table, const char* key, Eigen::Vector3d& to) {
    if (!table.has(key)) return;
    const std::vector<double> values = table.numbers(key);
    if (values.size() != 3) return table.complain(key, "must be three numbers, x y z in mm");
    to = {values[0], values[1], values[2]};
}

std::string read_name(const core::ConfigTable& table, const char* key, const std::string& fallback) {
    std::string text = table.text(key, fallback);
    for (const char c : text)
        if (c < ' ' || c > '~') table.complain(key, "must be plain ASCII");
    if (text.size() > 16) table.complain(key, "is longer than the 16 characters that the register map has for it");
    return text;
}

}  // namespace

core::Result<MachineSettings> load_machine_settings(const std::string& file) {
    const auto root = core::ConfigTable::load(file);
    if (!root) return tl::unexpected(root.error());
    return read_machine_settings(*root);
}

core::Result<MachineSettings> read_machine_settings(const core::ConfigTable& root) {
    root.ignore("link");
    root.ignore("uncertainty");
    const core::ConfigTable in = root.table("controller");
    MachineSettings to;
    to.model = read_name(in, "model", to.model);
    to.serial = read_name(in, "serial", to.serial);
    to.lsb_mm = in.number("lsb_nm", 100, {1, 65535}) * 1e-6;
    read_axes(in, "limit_min_mm", to.limit_min_mm);
    read_axes(in, "limit_max_mm", to.limit_max_mm);
    read_axes(in, "home_mm", to.home_mm);
    to.max_speed_mm_s = in.number("max_speed_mm_s", to.max_speed_mm_s, {0.1, 2000});
    to.max_accel_mm_s2 = in.number("max_accel_mm_s2", to.max_accel_mm_s2, {1, 50000});
    to.sample_rate_hz = static_cast<int>(in.integer("sample_rate_hz", to.sample_rate_hz, {1, 4000}));
    to.fifo_depth = static_cast<std::size_t>(in.integer("fifo_depth", 8192, {16, 65535}));
    to.path_capacity = static_cast<std::size_t>(in.integer("path_capacity", 4096, {16, 65535}));
    to.watchdog_ms = static_cast<int>(in.integer("watchdog_ms", to.watchdog_ms, {50, 60000}));
    // Positions travel as 32-bit counts.
    const double reach_mm = 2147483647.0 * to.lsb_mm;
    if (!(to.limit_min_mm.array() < to.limit_max_mm.array()).all())
        in.complain("limit_max_mm", "must lie above limit_min_mm in every axis");
    else if (to.limit_min_mm.cwiseAbs().maxCoeff() > reach_mm || to.limit_max_mm.cwiseAbs().maxCoeff() > reach_mm)
        in.complain("limit_max_mm", "the travel does not fit into 32-bit counts of this lsb_nm");
    else if ((to.home_mm.array() < to.limit_min_mm.array()).any() ||
             (to.home_mm.array() > to.limit_max_mm.array()).any())
        in.complain("home_mm", "lies outside the travel limits");
    if (const auto status = root.finish(); !status) return tl::unexpected(status.error());
    return to;
}

}  // namespace cmm::sim
