// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "drivers/registry.hpp"

namespace cmm::app {

/// Everything that a machine's URL can lead to: the drivers, and run files played again.
drivers::Registry machine_registry();

}  // namespace cmm::app
