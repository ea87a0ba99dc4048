// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "drivers/endpoint.hpp"
#include "drivers/modbus/link.hpp"

namespace cmm::drivers::modbus {

/// The link that an endpoint of one of the Modbus schemes asks for, not yet open.
std::unique_ptr<Link> make_link(const Endpoint& endpoint);

}  // namespace cmm::drivers::modbus
