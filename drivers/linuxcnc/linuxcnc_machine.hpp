// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/error.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::linuxcnc {

/// A measuring machine that LinuxCNC moves, commanded through linuxcncrsh (`linuxcnc://`, docs/linuxcnc.md). It
/// measures by single touches (G38.3); positions come from where its servo cycle saw the probe trip, with the host's
/// time. It cannot scan along a path. LinuxCNC has no watchdog for us: a motion whose host has died goes on to its end,
/// which for a touch is the contact or the target. Makes the machine without connecting. Errors: usage (port 0).
core::Result<std::unique_ptr<Machine>> make_linuxcnc_machine(const LinkSettings& settings,
                                                             const DriverContext& context);

}  // namespace cmm::drivers::linuxcnc
