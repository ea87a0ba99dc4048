// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "core/config.hpp"

namespace cmm::drivers {

/// By how much a machine and its probe may err, as a data sheet or an acceptance test says it: the table [uncertainty]
/// of a machine file (config/machines/sim.toml explains the keys). What is not said is none. Largest permissible
/// errors, but for the ball's radius, which is a standard uncertainty. A plain value.
struct MachineErrors {
    std::optional<double> length_mm;        ///< A of E0,MPE = A + L/K (ISO 10360-2)
    std::optional<double> length_share;     ///< 1/K, mm per mm
    std::optional<double> probing_form_mm;  ///< P_Form.Sph (ISO 10360-5): range of the distances from a sphere's centre
    std::optional<double> probing_size_mm;  ///< P_Size.Sph: of a sphere's diameter
    std::optional<double> ball_standard_mm;  ///< of the qualified radius

    bool operator==(const MachineErrors&) const = default;
    /// What is said here, the rest as `others` say it.
    MachineErrors or_else(const MachineErrors& others) const;
};

/// Every figure under its name: one list for files, run files and results.
inline constexpr std::array<std::pair<const char*, std::optional<double> MachineErrors::*>, 5> machine_figures{
    {{"length_mm", &MachineErrors::length_mm},
     {"length_share", &MachineErrors::length_share},
     {"probing_form_mm", &MachineErrors::probing_form_mm},
     {"probing_size_mm", &MachineErrors::probing_size_mm},
     {"ball_standard_mm", &MachineErrors::ball_standard_mm}}};

/// Of an [uncertainty] table, which may hold other keys as well.
MachineErrors read_machine_errors(const core::ConfigTable& table);

}  // namespace cmm::drivers
