// SPDX-License-Identifier: Apache-2.0
#include "drivers/serial_ports.hpp"

#include <libserialport.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <string_view>

#include "core/text.hpp"

namespace cmm::drivers {
namespace {

namespace fs = std::filesystem;

std::string text_or_empty(const char* text) {
    return text == nullptr ? std::string() : std::string(text);
}

std::string name_of(sp_transport transport) {
    switch (transport) {
        case SP_TRANSPORT_NATIVE:
            return "native";
        case SP_TRANSPORT_USB:
            return "usb";
        case SP_TRANSPORT_BLUETOOTH:
            return "bluetooth";
    }
    return {};
}

SerialPort describe(const sp_port* port) {
    SerialPort found;
    found.device = text_or_empty(sp_get_port_name(port));
    found.description = text_or_empty(sp_get_port_description(port));
    found.transport = name_of(sp_get_port_transport(port));
    int vendor = 0;
    int product = 0;
    if (sp_get_port_usb_vid_pid(port, &vendor, &product) == SP_OK)
        found.usb = SerialPort::UsbId{static_cast<std::uint16_t>(vendor), static_cast<std::uint16_t>(product)};
    found.manufacturer = text_or_empty(sp_get_port_usb_manufacturer(port));
    found.product = text_or_empty(sp_get_port_usb_product(port));
    found.serial_number = text_or_empty(sp_get_port_usb_serial(port));
    found.holders = holders_of(found.device);
    return found;
}

std::optional<int> process_number(const fs::path& entry) {
    const std::string name = entry.filename();
    int pid = 0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), pid);
    if (error != std::errc{} || end != name.data() + name.size()) return std::nullopt;
    return pid;
}

bool holds(const fs::path& process, const fs::path& device) {
    std::error_code denied;  // or the process has ended meanwhile
    for (fs::directory_iterator at(process / "fd", denied), end; !denied && at != end; at.increment(denied)) {
        std::error_code gone;
        if (fs::read_symlink(at->path(), gone) == device) return true;
    }
    return false;
}

}  // namespace

std::vector<DeviceHolder> holders_of(const std::string& device) {
    std::error_code ignored;
    const fs::path target = fs::canonical(device, ignored);
    std::vector<DeviceHolder> holders;
    if (ignored) return holders;
    for (fs::directory_iterator at("/proc", ignored), end; !ignored && at != end; at.increment(ignored)) {
        const fs::path process = at->path();
        const auto pid = process_number(process);
        if (!pid || *pid == ::getpid() || !holds(process, target)) continue;
        const auto name = core::read_file((process / "comm").string());
        holders.push_back({*pid, name ? std::string(core::trim(*name)) : std::string()});
    }
    std::sort(holders.begin(), holders.end(), [](const auto& a, const auto& b) { return a.pid < b.pid; });
    return holders;
}

core::Result<std::vector<SerialPort>> list_serial_ports() {
    sp_port** list = nullptr;
    if (sp_list_ports(&list) != SP_OK)
        return core::fail(core::ErrorCode::internal, "the system does not list its serial ports");
    const std::unique_ptr<sp_port*, decltype(&sp_free_port_list)> owner(list, &sp_free_port_list);
    std::vector<SerialPort> ports;
    for (sp_port** port = list; *port != nullptr; ++port)
        ports.push_back(describe(*port));
    std::sort(ports.begin(), ports.end(), [](const auto& a, const auto& b) { return a.device < b.device; });
    return ports;
}

core::Result<SerialPort> look_at_device(const std::string& device) {
    std::error_code absent;
    if (!fs::exists(device, absent)) return core::fail(core::ErrorCode::input_missing, device + ": is not there");
    SerialPort found;
    sp_port* port = nullptr;
    const std::string target = fs::canonical(device, absent).string();
    if (sp_get_port_by_name(target.c_str(), &port) == SP_OK) {
        found = describe(port);
        sp_free_port(port);
    } else {
        found.description = target.starts_with("/dev/pts/") ? "pseudo-terminal" : "not known as a serial port";
        found.holders = holders_of(target);
    }
    found.device = device;
    return found;
}

}  // namespace cmm::drivers
