// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/rtu_frame.hpp"

#include <algorithm>

#include "drivers/modbus/crc16.hpp"

namespace cmm::drivers::modbus {
namespace {

std::uint16_t crc_of(std::span<const std::uint8_t> bytes) noexcept {
    Crc16 crc;
    for (const std::uint8_t byte : bytes)
        crc.feed(byte);
    return crc.value();
}

/// Bytes of a whole reply that begins so; 0: no reply of ours does.
std::size_t whole_size(std::span<const std::uint8_t> bytes) noexcept {
    const std::uint8_t function = bytes[1];
    if ((function & 0x80U) != 0) return 5;
    switch (function) {
        case 6:
        case 16:
            return 8;
        case 3:
        case 23:
            return bytes.size() < 3 ? 5 : std::size_t{5} + bytes[2];
        default:
            return 0;
    }
}

}  // namespace

std::size_t rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu,
                      std::span<std::uint8_t, max_frame> frame) noexcept {
    frame[0] = unit;
    std::copy(pdu.begin(), pdu.end(), frame.begin() + 1);
    const std::size_t used = 1 + pdu.size();
    const std::uint16_t crc = crc_of(std::span(frame).first(used));
    frame[used] = static_cast<std::uint8_t>(crc & 0xFFU);
    frame[used + 1] = static_cast<std::uint8_t>(crc >> 8U);
    return used + 2;
}

RtuCut cut_rtu(std::span<const std::uint8_t> bytes, std::uint8_t unit) noexcept {
    RtuCut cut;
    if (bytes.size() < 2) return cut;
    const std::size_t size = whole_size(bytes);
    cut.kind = RtuCut::Kind::garbled;
    if (size == 0 || size > max_rtu_frame) return cut;
    if (bytes.size() < size) {
        cut.kind = RtuCut::Kind::partial;
        return cut;
    }
    const auto covered = bytes.first(size - 2);
    const std::uint16_t crc = static_cast<std::uint16_t>(bytes[size - 2] | bytes[size - 1] << 8U);
    if (crc_of(covered) != crc) return cut;
    cut.kind = bytes[0] == unit ? RtuCut::Kind::reply : RtuCut::Kind::foreign;
    cut.size = size;
    cut.pdu = covered.subspan(1);
    return cut;
}

}  // namespace cmm::drivers::modbus
