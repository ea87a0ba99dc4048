// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "core/error.hpp"

namespace cmm::drivers::modbus {

inline constexpr std::size_t max_read = 125;   ///< registers of one reply (FC 3, FC 23)
inline constexpr std::size_t max_write = 123;  ///< registers of one FC 16

/// CRC-16/MODBUS (poly 0xA001 reflected, start 0xFFFF) over registers as bytes, high byte first, leaving out register
/// `skip`.
std::uint16_t crc16(std::span<const std::uint16_t> registers, std::size_t skip) noexcept;

/// Where a number lies in its block: whole registers, or some bits of them (a packed status word).
struct Field {
    std::uint16_t at = 0;
    std::uint16_t words = 1;  ///< 1 or 2
    std::uint16_t shift = 0;  ///< lowest bit
    std::uint16_t bits = 16;
};

/// Where a controller keeps what. A value-initialised map is version 1 (config/maps/cmm-v1.toml,
/// docs/protocol-modbus.md); another layout comes from a file. Members named like the keys of the file; offsets count
/// within their block. A plain value.
struct RegisterMap {
    std::string name = "cmm-v1";
    std::uint16_t version = 1;
    bool high_word_first = true;

    struct Identity {
        std::uint16_t address = 0, length = 46, magic = 0, map_version = 2, firmware = 3, model = 4, serial = 12;
        std::uint16_t lsb_nm = 20, sample_rate_hz = 21, fifo_depth = 22, path_capacity = 23, path_window = 24;
        std::uint16_t watchdog_ms = 25, capabilities = 26, deflection_lsb_um = 27, limit_min = 28, limit_max = 34;
        std::uint16_t max_speed_um_s = 40, max_accel_um_s2 = 42, boot_id = 44, crc = 45;
    } identity;
    struct Status {
        std::uint16_t address = 64, length = 37;
        Field state{0}, flags{2}, fault{3}, command_state{5}, result{6}, path_recorded{16, 2, 0, 32};
        Field path_received{18, 2, 0, 32}, fifo_level{30};
        std::uint16_t heartbeat = 1, command_seq = 4, values = 7, active_path = 15, newest_seq = 20, acked_seq = 22;
        std::uint16_t position = 24, time_us = 31, owner = 34, crc = 36;
    } status;
    struct Command {
        std::uint16_t address = 128, length = 21, seq = 0, opcode = 1, owner = 2, args = 4, crc = 20;
    } command;
    struct Stop {
        std::uint16_t address = 200;
    } stop;
    struct Path {
        std::uint16_t address = 256, header = 6, path = 0, first_index = 1, count = 3, crc = 4, reserved = 5;
        std::uint16_t point_length = 11, position = 0, normal = 6, speed = 9, flags = 10;  // of a point
    } path;
    struct Exchange {
        std::uint16_t address = 384, watchdog = 0, ack_seq = 1, from_seq = 3;
    } exchange;
    struct Fifo {
        std::uint16_t address = 400, length = 125;
        Field state{0}, flags{8};
        std::uint16_t heartbeat = 1, path = 2, first_seq = 3, newest_seq = 5, count = 7, time_us = 9, crc = 12;
        std::uint16_t points = 13, point_length = 8, position = 0, dt = 6, quality = 7;  // the last three of a point
    } fifo;
    struct Scale {
        double count_mm = 0.0;     ///< 0: as the identity block says
        double speed_mm_s = 0.01;  ///< of a path point
        double normal = 32767.0;   ///< a component of 1
        std::int64_t dt_us = 10;   ///< between samples
    } scale;

    /// Errors: input_missing, config_syntax, config_invalid (file:line:column).
    static core::Result<RegisterMap> load(const std::string& file);

    std::uint32_t value(std::span<const std::uint16_t> block, const Field& field) const noexcept;
    /// The count of a field that goes round at its width: the one nearest to `near`, which is not more than half a
    /// round away.
    static std::uint32_t unwrapped(const Field& field, std::uint32_t value, std::uint32_t near) noexcept;
    std::uint32_t u32(std::span<const std::uint16_t> block, std::size_t at) const noexcept;
    std::int32_t i32(std::span<const std::uint16_t> block, std::size_t at) const noexcept;
    std::int64_t u48(std::span<const std::uint16_t> block, std::size_t at) const noexcept;
    void put_u32(std::span<std::uint16_t> block, std::size_t at, std::uint32_t value) const noexcept;
    void put_i32(std::span<std::uint16_t> block, std::size_t at, std::int32_t value) const noexcept;
};

inline constexpr std::size_t exchange_length = 5;  ///< registers written by the FIFO exchange

}  // namespace cmm::drivers::modbus
