// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/modbus_machine.hpp"

#include <string>
#include <utility>

#include "drivers/controller/controller_machine.hpp"
#include "drivers/modbus/modbus_port.hpp"

namespace cmm::drivers::modbus {

core::Result<std::unique_ptr<Machine>> make_modbus_machine(const LinkSettings& settings, const DriverContext& context) {
    if (settings.endpoint.port == 0 && !settings.endpoint.host.empty()) {
        return core::fail(core::ErrorCode::usage, "endpoint \"" + settings.endpoint.text() +
                                                      "\": port 0 is for listeners; name the controller's port");
    }
    if (settings.endpoint.word("pty", "no") == "yes") {
        return core::fail(core::ErrorCode::usage,
                          "endpoint \"" + settings.endpoint.text() + "\": pty=yes is for listeners; leave it out here");
    }
    RegisterMap map;
    if (!settings.map_file.empty()) {
        auto loaded = RegisterMap::load(settings.map_file);
        if (!loaded) return tl::unexpected(loaded.error());
        map = std::move(*loaded);
    }
    auto port = std::make_unique<ModbusPort>(settings, std::move(map), context);
    return controller::make_controller_machine(std::move(port), settings.poll_ms, context);
}

}  // namespace cmm::drivers::modbus
