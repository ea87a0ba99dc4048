// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/error.hpp"
#include "drivers/link_stats.hpp"
#include "drivers/machine.hpp"

namespace cmm::app {

/// What a machine says of itself.
struct MachineReport {
    drivers::Capabilities capabilities;
    drivers::MachineStatus status;
    drivers::LinkStats link;
};

/// Connects, looks, goes: takes no ownership and changes nothing. `machine` is a URL or a machine file.
core::Result<MachineReport> ask_machine(const std::string& machine);

}  // namespace cmm::app
