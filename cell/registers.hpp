// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "cell/modbus_request.hpp"

/// The cell's register map, version 1 (docs/cell.md): one block that the PLC writes, one that it reads. 32-bit numbers
/// have their high word first, text its first character in the high byte.
namespace cmm::cell {

inline constexpr std::size_t serial_registers = 16;
inline constexpr std::size_t longest_serial = 2 * serial_registers;

namespace command_bit {
inline constexpr std::uint16_t part_present = 1, start = 2, abort = 4, acknowledge = 8;
inline constexpr std::uint16_t all = part_present | start | abort | acknowledge;
}  // namespace command_bit

namespace status_bit {
inline constexpr std::uint16_t ready = 1, busy = 2, done = 4, rejected_for_certain = 8, plc_lives = 16,
                               may_be_moving = 32, held = 64;
}  // namespace status_bit

/// Registers that the PLC writes, from `first` on.
struct PlcBlock {
    static constexpr std::uint16_t first = 0;
    enum At : std::uint16_t { heartbeat, command, program, reserved, serial, count = serial + serial_registers };
    std::array<std::uint16_t, count> words{};

    bool has(std::uint16_t bit) const { return (words[command] & bit) != 0; }
    /// Up to the first zero, blanks at its end taken off.
    std::string serial_text() const;
};

/// Registers that the PLC reads, from `first` on.
struct CellBlock {
    static constexpr std::uint16_t first = 100;
    enum At : std::uint16_t {
        identity,           // 0x4345, 0x4C4C: "CELL"
        map_version = 2,    // 1
        heartbeat,          // counts up ten times a second
        status,             // status_bit
        state,              // CellState
        result,             // CellResult, none until done
        reason,             // Reason, none until done
        decision,           // CellResult as far as it is certain while the part is measured: none or rejected
        decided_section,    // from 1 on; 0: none
        run,                // 32 bits
        program = run + 2,  // as taken on
        progress,           // thousandths
        section,            // under the probe, from 1 on
        watchdog_ms,        // how long the PLC's heartbeat may stand still
        plc_heartbeat,      // the last one seen
        serial,             // as taken on
        count = serial + serial_registers
    };
    std::array<std::uint16_t, count> words{};

    CellBlock();
    void put_serial(const std::string& text);
    void put_run(std::uint32_t number);
};

/// Reading and writing both blocks by the rules of the map. Errors of a write leave everything as it was.
///  - Reading: within one of the blocks, otherwise illegal address.
///  - Writing: within the PLC's block, otherwise illegal address; unknown command bits and a reserved register that is
///    not 0 are illegal values.
ModbusException read_registers(const PlcBlock& plc, const CellBlock& cell, std::size_t address,
                               std::span<std::uint16_t> to) noexcept;
ModbusException write_registers(PlcBlock& plc, std::size_t address, std::span<const std::uint16_t> from) noexcept;

/// Printable ASCII without '"' and '\': what a part file's serial number may be made of.
bool is_serial(const std::string& text) noexcept;

}  // namespace cmm::cell
