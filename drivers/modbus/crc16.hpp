// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace cmm::drivers::modbus {

/// CRC-16/MODBUS (poly 0xA001 reflected, start 0xFFFF), byte by byte (Modbus over serial line 1.02, 6.2.2).
class Crc16 {
  public:
    void feed(std::uint8_t byte) noexcept {
        value_ = static_cast<std::uint16_t>((value_ >> 8U) ^ table_[(value_ ^ byte) & 0xFFU]);
    }
    std::uint16_t value() const noexcept { return value_; }

  private:
    static constexpr auto table_ = [] {
        std::array<std::uint16_t, 256> entries{};
        for (std::uint16_t k = 0; k < 256; ++k) {
            std::uint16_t value = k;
            for (int bit = 0; bit < 8; ++bit) {
                value = static_cast<std::uint16_t>((value & 1U) != 0 ? (value >> 1U) ^ 0xA001U : value >> 1U);
            }
            entries[k] = value;
        }
        return entries;
    }();
    std::uint16_t value_ = 0xFFFF;
};

}  // namespace cmm::drivers::modbus
