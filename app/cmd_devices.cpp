// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdio>

#include "acquisition/json_text.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "drivers/serial_ports.hpp"

namespace cmm::app {
namespace {

using acquisition::JsonFields;
using drivers::SerialPort;

std::string hex4(std::uint16_t number) {
    std::array<char, 5> text{};
    std::snprintf(text.data(), text.size(), "%04x", static_cast<unsigned>(number));
    return text.data();
}

std::string usb_text(const SerialPort& port) {
    return port.usb ? hex4(port.usb->vendor) + ":" + hex4(port.usb->product) : std::string();
}

std::string json_of(const SerialPort& port) {
    std::string holders;
    for (const auto& holder : port.holders) {
        holders += (holders.empty() ? "{" : ",{") +
                   JsonFields().add("pid", holder.pid).add("program", holder.program).text() + "}";
    }
    return "{" +
           JsonFields()
               .add("device", port.device)
               .add("description", port.description)
               .add("transport", port.transport)
               .add("usb_id", usb_text(port))
               .add("manufacturer", port.manufacturer)
               .add("product", port.product)
               .add("serial_number", port.serial_number)
               .raw("held_by", "[" + holders + "]")
               .text() +
           "}";
}

void print(const SerialPort& port) {
    std::printf("%s  %s", port.device.c_str(), port.description.c_str());
    for (const std::string& text : {port.transport, usb_text(port), port.manufacturer, port.product})
        if (!text.empty()) std::printf(", %s", text.c_str());
    if (!port.serial_number.empty()) std::printf(", serial number %s", port.serial_number.c_str());
    std::printf("\n");
    for (const auto& holder : port.holders)
        std::printf("    held by %s (process %d)\n", holder.program.c_str(), holder.pid);
}

}  // namespace

int run_devices(const DevicesOptions& options) {
    auto ports = drivers::list_serial_ports();
    if (!ports) return report(ports.error(), options.json);
    for (const auto& device : options.devices) {
        auto port = drivers::look_at_device(device);
        if (!port) return report(port.error(), options.json);
        ports->push_back(std::move(*port));
    }
    if (options.json) {
        std::string list;
        for (const auto& port : *ports)
            list += (list.empty() ? "" : ",") + json_of(port);
        std::printf("{\"devices\":[%s]}\n", list.c_str());
        return 0;
    }
    if (ports->empty()) std::printf("no serial ports\n");
    for (const auto& port : *ports)
        print(port);
    return 0;
}

}  // namespace cmm::app
