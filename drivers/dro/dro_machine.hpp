// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "core/error.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::dro {

/// A manual measuring machine, arm or digital readout that prints coordinates on a serial port (`dro+serial://`,
/// docs/dro.md). It cannot move (Capabilities::moves): receive() delivers what a person measures, everything that would
/// be motion is refused. Points have the host's time for want of another. Makes the machine without opening the port.
/// Errors: usage (a pty to be made), config_invalid (format).
core::Result<std::unique_ptr<Machine>> make_dro_machine(const LinkSettings& settings, const DriverContext& context);

}  // namespace cmm::drivers::dro
