// SPDX-License-Identifier: Apache-2.0
#include "acquisition/recorded_machine.hpp"

#include <type_traits>

namespace cmm::acquisition {
namespace {

/// Every number under its name: one list for writing and for reading.
template <class Machine, class Visit>
void for_each_number(Machine& machine, const Visit& visit) {
    visit("moves", machine.moves);
    visit("scans_paths", machine.scans_paths);
    visit("touches", machine.touches);
    visit("gives_deflection", machine.gives_deflection);
    visit("appends_paths", machine.appends_paths);
    visit("sample_rate_hz", machine.sample_rate_hz);
    visit("fifo_depth", machine.fifo_depth);
    visit("path_capacity", machine.path_capacity);
    visit("path_window", machine.path_window);
    visit("deflection_lsb_mm", machine.deflection_lsb_mm);
    visit("limit_min_x_mm", machine.limit_min_mm.x());
    visit("limit_min_y_mm", machine.limit_min_mm.y());
    visit("limit_min_z_mm", machine.limit_min_mm.z());
    visit("limit_max_x_mm", machine.limit_max_mm.x());
    visit("limit_max_y_mm", machine.limit_max_mm.y());
    visit("limit_max_z_mm", machine.limit_max_mm.z());
    visit("max_speed_mm_s", machine.max_speed_mm_s);
    visit("max_acceleration_mm_s2", machine.max_acceleration_mm_s2);
    visit("watchdog_ms", machine.watchdog_ms);
}

constexpr double largest_size = 1e9;  // of a buffer; a file may claim anything

template <class Value>
Value value_of(double number) {
    if constexpr (std::is_same_v<Value, bool>) return number != 0.0;
    if constexpr (std::is_integral_v<Value>)
        return number >= 0.0 && number < largest_size ? static_cast<Value>(number) : 0;
    return static_cast<Value>(number);
}

constexpr const char* errors_key = "uncertainty_";  // before the name of a figure

}  // namespace

void add_errors(const drivers::MachineErrors& errors, std::map<std::string, double>& numbers) {
    for (const auto& [name, figure] : drivers::machine_figures)
        if (const auto& value = errors.*figure) numbers.emplace(std::string(errors_key) + name, *value);
}

drivers::MachineErrors recorded_errors(const Journal::Header& header) {
    drivers::MachineErrors errors;
    for (const auto& [name, figure] : drivers::machine_figures) {
        const auto found = header.capabilities.find(std::string(errors_key) + name);
        // A file may claim anything.
        if (found != header.capabilities.end() && found->second >= 0.0 && found->second <= 1.0)
            errors.*figure = found->second;
    }
    return errors;
}

std::map<std::string, double> capability_numbers(const drivers::Capabilities& machine) {
    std::map<std::string, double> numbers;
    for_each_number(machine,
                    [&](const char* name, const auto& value) { numbers.emplace(name, static_cast<double>(value)); });
    return numbers;
}

core::Result<drivers::Capabilities> recorded_capabilities(const Journal::Header& header) {
    drivers::Capabilities machine;
    std::string missing;
    for_each_number(machine, [&](const char* name, auto& value) {
        const auto found = header.capabilities.find(name);
        if (found == header.capabilities.end()) {
            if (missing.empty()) missing = name;
        } else {
            value = value_of<std::remove_reference_t<decltype(value)>>(found->second);
        }
    });
    if (!missing.empty()) {
        return core::fail(core::ErrorCode::input_invalid,
                          "the run does not say what its machine could do (" + missing +
                              "): it was recorded by an older version; `cmmlive fit` reads it all the same");
    }
    machine.model = header.machine_model;
    machine.serial = header.machine_serial;
    machine.firmware = "recorded by " + header.software_version;
    machine.boot_id = header.boot_id;
    machine.lsb_mm = header.lsb_mm;
    machine.recorded_plan = header.plan_hash;
    machine.recorded_errors = recorded_errors(header);
    return machine;
}

}  // namespace cmm::acquisition
