// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "drivers/endpoint.hpp"

namespace cmm::drivers {

enum class Parity : std::uint8_t { none, even, odd };

/// A serial port and how it is set. A plain value.
struct SerialSettings {
    std::string device;
    int baud = 115200;
    Parity parity = Parity::none;
    int stop_bits = 1;
    int data_bits = 8;  ///< 7 or 8; binary protocols have 8

    /// Of an endpoint with a device; where the URL says nothing, the parity is the protocol's default.
    static SerialSettings of(const Endpoint& endpoint, Parity default_parity);
    /// Start, data, parity and stop bits.
    int bits_per_byte() const noexcept { return 1 + data_bits + (parity == Parity::none ? 0 : 1) + stop_bits; }
    double byte_ms() const noexcept { return 1e3 * bits_per_byte() / baud; }
};

}  // namespace cmm::drivers
