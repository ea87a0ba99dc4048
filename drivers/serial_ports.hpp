// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/error.hpp"

namespace cmm::drivers {

/// A process that has a device open.
struct DeviceHolder {
    int pid = 0;
    std::string program;
};

/// What the system knows of a serial port. Empty: not known. A plain value.
struct SerialPort {
    std::string device;  ///< the name that was given or found
    std::string description;
    std::string transport;  ///< "native", "usb", "bluetooth"
    struct UsbId {
        std::uint16_t vendor = 0, product = 0;
    };
    std::optional<UsbId> usb;
    std::string manufacturer, product, serial_number;
    std::vector<DeviceHolder> holders;  ///< as far as we may look
};

/// All ports that libserialport finds (native, USB, Bluetooth; never pseudo-terminals), by name, with their holders.
/// Errors: internal (the system refuses to list them).
core::Result<std::vector<SerialPort>> list_serial_ports();
/// One device by its name, whatever it is. Errors: input_missing.
core::Result<SerialPort> look_at_device(const std::string& device);
/// The processes that have the device (or what the link leads to) open, this one left out. Those of other users cannot
/// be seen without privileges.
std::vector<DeviceHolder> holders_of(const std::string& device);

}  // namespace cmm::drivers
