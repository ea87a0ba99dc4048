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
        std::uint16_t address = 64, length = 37, state = 0, heartbeat = 1, flags = 2, fault = 3, command_seq = 4;
        std::uint16_t command_state = 5, result = 6, values = 7, active_path = 15, path_recorded = 16;
        std::uint16_t path_received = 18, newest_seq = 20, acked_seq = 22, position = 24, fifo_level = 30;
        std::uint16_t time_us = 31, owner = 34, crc = 36;
    } status;
    struct Command {
        std::uint16_t address = 128, length = 21, seq = 0, opcode = 1, owner = 2, args = 4, crc = 20;
    } command;
    struct Stop {
        std::uint16_t address = 200;
    } stop;
    struct Path {
        std::uint16_t address = 256, header = 6, path = 0, first_index = 1, count = 3, crc = 4, reserved = 5;
        std::uint16_t point_length = 11;
    } path;
    struct Exchange {
        std::uint16_t address = 384, watchdog = 0, ack_seq = 1, from_seq = 3;
    } exchange;
    struct Fifo {
        std::uint16_t address = 400, length = 125, state = 0, heartbeat = 1, path = 2, first_seq = 3, newest_seq = 5;
        std::uint16_t count = 7, flags = 8, time_us = 9, crc = 12, points = 13, point_length = 8;
    } fifo;

    /// Errors: input_missing, config_syntax, config_invalid (file:line:column).
    static core::Result<RegisterMap> load(const std::string& file);

    std::uint32_t u32(std::span<const std::uint16_t> block, std::size_t at) const noexcept;
    std::int32_t i32(std::span<const std::uint16_t> block, std::size_t at) const noexcept;
    std::int64_t u48(std::span<const std::uint16_t> block, std::size_t at) const noexcept;
    void put_u32(std::span<std::uint16_t> block, std::size_t at, std::uint32_t value) const noexcept;
    void put_i32(std::span<std::uint16_t> block, std::size_t at, std::int32_t value) const noexcept;
};

inline constexpr std::size_t exchange_length = 5;  ///< registers written by the FIFO exchange

}  // namespace cmm::drivers::modbus
