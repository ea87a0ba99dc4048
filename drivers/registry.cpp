// SPDX-License-Identifier: Apache-2.0
#include "drivers/registry.hpp"

#include <utility>

#include "core/text.hpp"
#include "drivers/dro/dro_machine.hpp"
#include "drivers/line/line_port.hpp"
#include "drivers/linuxcnc/linuxcnc_machine.hpp"
#include "drivers/modbus/modbus_machine.hpp"

namespace cmm::drivers {

void Registry::add(Entry entry) {
    entries_.push_back(std::move(entry));
}

core::Result<std::unique_ptr<Machine>> Registry::make(const LinkSettings& link, const DriverContext& context) const {
    std::vector<std::string_view> names;
    std::string list;
    for (const Entry& entry : entries_) {
        if (entry.scheme == link.endpoint.scheme) return entry.factory(link, context);
        names.push_back(entry.scheme);
        list += (list.empty() ? "" : ", ") + entry.scheme;
    }
    std::string what = "no driver serves \"" + link.endpoint.scheme + ":\"; there are: " + list;
    if (const auto near = core::nearest_word(link.endpoint.scheme, names)) what += "; did you mean \"" + *near + "\"?";
    return core::fail(core::ErrorCode::usage, what);
}

Registry standard_registry() {
    Registry registry;
    registry.add(
        {"modbus+tcp", "a controller behind Modbus TCP (docs/protocol-modbus.md)", &modbus::make_modbus_machine});
    registry.add({"modbus+rtu", "the same on a serial line", &modbus::make_modbus_machine});
    registry.add({"modbus+rtu+tcp", "the same behind a gateway that passes RTU frames on unchanged",
                  &modbus::make_modbus_machine});
    registry.add({"line+serial", "a controller that speaks text lines and sample frames (docs/protocol-line.md)",
                  &line::make_line_machine});
    registry.add({"dro+serial", "a manual machine, arm or digital readout that prints its points (docs/dro.md)",
                  &dro::make_dro_machine});
    registry.add({"linuxcnc", "LinuxCNC through linuxcncrsh, by single touches (docs/linuxcnc.md)",
                  &linuxcnc::make_linuxcnc_machine});
    return registry;
}

}  // namespace cmm::drivers
