// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "drivers/machine.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::modbus {

/// Makes a machine behind `modbus+tcp://`, `modbus+rtu://` or `modbus+rtu+tcp://` (docs/protocol-modbus.md) without
/// connecting. Errors: usage (port 0, a pty to be made), those of the register map file.
core::Result<std::unique_ptr<Machine>> make_modbus_machine(const LinkSettings& settings, const DriverContext& context);

}  // namespace cmm::drivers::modbus
