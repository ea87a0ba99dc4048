// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>

#include "acquisition/event_payload.hpp"
#include "acquisition/json_text.hpp"
#include "app/ask_machine.hpp"
#include "app/commands.hpp"
#include "app/console.hpp"
#include "app/machines.hpp"
#include "core/text.hpp"
#include "drivers/serial_ports.hpp"

namespace cmm::app {
namespace {

std::string triple(const Eigen::Vector3d& v) {
    return core::fixed(v.x(), 3) + " " + core::fixed(v.y(), 3) + " " + core::fixed(v.z(), 3);
}

void print_machine(const MachineReport& found) {
    const auto& c = found.capabilities;
    std::printf("machine:     %s %s, firmware %s, boot %u\n", c.model.c_str(), c.serial.c_str(), c.firmware.c_str(),
                c.boot_id);
    std::printf("can:         %s%s%s%s\n", c.scans_paths ? "scan " : "", c.touches ? "touch " : "",
                c.gives_deflection ? "deflection " : "", c.appends_paths ? "append" : "");
    std::printf("count:       %s um; sample clock %.0f Hz; FIFO %zu samples; watchdog %.0f ms\n",
                core::fixed(c.lsb_mm * 1e3, 3).c_str(), c.sample_rate_hz, c.fifo_depth, c.watchdog_ms);
    std::printf("travel:      %s ... %s mm; at most %.0f mm/s\n", triple(c.limit_min_mm).c_str(),
                triple(c.limit_max_mm).c_str(), c.max_speed_mm_s);
    std::printf("state:       %s, %s, %s, at %s mm%s%s\n", std::string(drivers::to_string(found.status.state)).c_str(),
                found.status.homed ? "homed" : "not homed", found.status.qualified ? "qualified" : "not qualified",
                triple(found.status.position_mm).c_str(),
                found.status.fault.empty() ? "" : ", fault: ", found.status.fault.c_str());
    std::printf("link:        {%s}\n", acquisition::link_payload(found.link).c_str());
}

std::string machine_json(const MachineReport& found) {
    const auto& c = found.capabilities;
    const auto& at = found.status.position_mm;
    const std::string position = core::fixed(at.x(), 4) + "," + core::fixed(at.y(), 4) + "," + core::fixed(at.z(), 4);
    return "{" +
           acquisition::JsonFields()
               .add("model", c.model)
               .add("serial", c.serial)
               .add("firmware", c.firmware)
               .add("boot_id", c.boot_id)
               .add("lsb_mm", c.lsb_mm, 7)
               .add("sample_rate_hz", c.sample_rate_hz, 1)
               .add("fifo_depth", c.fifo_depth)
               .add("watchdog_ms", c.watchdog_ms, 1)
               .add("state", drivers::to_string(found.status.state))
               .add("homed", found.status.homed)
               .add("qualified", found.status.qualified)
               .add("fault", found.status.fault)
               .add("in_contact", found.status.in_contact)
               .raw("position_mm", "[" + position + "]")
               .raw("link", "{" + acquisition::link_payload(found.link) + "}")
               .text() +
           "}";
}

}  // namespace

int run_doctor(const DoctorOptions& options) {
    const auto folder = config_folder();
    if (!folder) return report(folder.error(), options.json);
    std::error_code code;
    const auto space = std::filesystem::space(".", code);
    const auto registry = machine_registry();
    const auto ports = drivers::list_serial_ports();
    if (!ports) return report(ports.error(), options.json);
    acquisition::JsonFields document;
    document.add("version", version())
        .add("config", *folder)
        .add("free_disk_mb", static_cast<std::uint64_t>(space.available >> 20U));
    if (!options.json) {
        std::printf("cmmlive:     %s\nconfig:      %s\nfree disk:   %llu MB here\n", version().c_str(), folder->c_str(),
                    static_cast<unsigned long long>(space.available >> 20U));
        for (const auto& driver : registry.entries())
            std::printf("driver:      %s  %s\n", driver.scheme.c_str(), driver.description.c_str());
        for (const auto& port : *ports)
            std::printf("serial port: %s  %s%s\n", port.device.c_str(), port.description.c_str(),
                        port.holders.empty() ? "" : ", held (`cmmlive devices` says by whom)");
    }
    if (!options.machine.empty()) {
        const auto found = ask_machine(options.machine);
        if (!found) return report(found.error(), options.json);
        if (options.json) {
            document.raw("machine", machine_json(*found));
        } else {
            print_machine(*found);
        }
    }
    if (options.json) std::printf("{%s}\n", document.text().c_str());
    return 0;
}

}  // namespace cmm::app
