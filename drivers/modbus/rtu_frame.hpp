// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/modbus/frame.hpp"

/// Modbus RTU frames (Modbus over serial line 1.02, 2.5.1): unit, PDU, CRC with its low byte first. Pure.
/// The end of a frame is told by its length, which follows from the function code: the silence that ends a frame by the
/// specification does not survive USB adapters and gateways. libmodbus' own receiver blocks and hands on what follows
/// noise, hence ours.
namespace cmm::drivers::modbus {

/// Returns the frame's number of bytes.
std::size_t rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu,
                      std::span<std::uint8_t, max_frame> frame) noexcept;

struct RtuCut {
    enum class Kind : std::uint8_t {
        partial,  ///< more bytes are needed
        reply,
        foreign,  ///< a whole frame of another unit
        garbled,  ///< no function of ours, or the CRC does not fit
    };
    Kind kind = Kind::partial;
    std::size_t size = 0;  ///< of the frame, when it is whole
    std::span<const std::uint8_t> pdu;
};
/// Looks for a reply at the front of the bytes received.
RtuCut cut_rtu(std::span<const std::uint8_t> bytes, std::uint8_t unit) noexcept;

}  // namespace cmm::drivers::modbus
