// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "drivers/controller/port.hpp"
#include "drivers/registry.hpp"

namespace cmm::drivers::controller {

/// A machine whose controller is reached through a port: the same operations whatever the protocol.
std::unique_ptr<Machine> make_controller_machine(std::unique_ptr<Port> port, double poll_ms,
                                                 const DriverContext& context);

}  // namespace cmm::drivers::controller
