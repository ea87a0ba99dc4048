// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/sample.hpp"
#include "drivers/machine.hpp"
#include "drivers/modbus/register_map.hpp"

/// The blocks of the register map as values: decoding with every check that a block can be given on its own, and
/// encoding. Pure.
namespace cmm::drivers::modbus {

enum class Opcode : std::uint16_t {
    claim = 1,
    release = 2,
    home = 3,
    qualify = 4,
    move = 5,
    touch = 6,
    scan = 7,
    clear_fault = 9,
    path_begin = 10,
};

/// What a result code means: text for people, error code for programs.
core::Error error_of_result(std::uint16_t result);

struct CommandBlock {
    std::uint16_t sequence = 0;
    Opcode opcode = Opcode::claim;
    std::uint32_t owner = 0;
    std::array<std::int32_t, 8> args{};
};
void encode(const RegisterMap& map, const CommandBlock& command, std::span<std::uint16_t> registers);

struct StatusBlock {
    std::uint16_t state = 0, heartbeat = 0, flags = 0, fault = 0, command_sequence = 0, command_state = 0, result = 0;
    std::array<std::int32_t, 4> values{};
    std::uint16_t path = 0;
    std::uint32_t path_passed = 0, path_received = 0, newest = 0, acknowledged = 0;
    std::array<std::int32_t, 3> position{};
    std::uint16_t fifo_level = 0;
    std::int64_t time_us = 0;
    std::uint32_t owner = 0;

    bool homed() const { return (flags & 1U) != 0; }
    bool qualified() const { return (flags & 2U) != 0; }
    bool in_contact() const { return (flags & 4U) != 0; }
    bool in_motion() const { return (flags & 8U) != 0; }
};
/// Errors: protocol_invalid (CRC, unknown state).
core::Status check_status(const RegisterMap& map, std::span<const std::uint16_t> registers);
/// Of registers that passed the check.
StatusBlock decode_status(const RegisterMap& map, std::span<const std::uint16_t> registers);

/// Errors: protocol_mismatch (not a controller of this map), protocol_invalid (CRC, values that cannot be).
core::Result<Capabilities> decode_identity(const RegisterMap& map, std::span<const std::uint16_t> registers);

/// The FIFO block; its points stay in the registers until `sample` is asked for them.
struct FifoBlock {
    std::uint16_t state = 0, path = 0, count = 0, flags = 0;
    std::uint32_t first = 0, newest = 0;  ///< controller sequence
    std::int64_t time_us = 0;

    bool overflow() const { return (flags & 1U) != 0; }
    bool more() const { return (flags & 2U) != 0; }
    bool path_ended() const { return (flags & 4U) != 0; }
};
/// Errors: protocol_invalid (count, CRC).
core::Status check_fifo(const RegisterMap& map, std::span<const std::uint16_t> registers);
/// Of registers that passed the check.
FifoBlock decode_fifo(const RegisterMap& map, std::span<const std::uint16_t> registers);
/// Decodes all points of the block; sequence numbers are the controller's, host time is left at 0. `samples` is
/// overwritten.
void decode_samples(const RegisterMap& map, std::span<const std::uint16_t> registers, const FifoBlock& block,
                    std::vector<core::Sample>& samples);

/// A path window: header and points. Returns the number of registers. `points` has at most the controller's path
/// window.
std::size_t encode_window(const RegisterMap& map, std::uint16_t path, std::uint32_t first_index,
                          std::span<const PathPoint> points, bool last, double lsb_mm,
                          std::span<std::uint16_t> registers);
/// Points that fit into one write by the map, whatever the controller says.
std::size_t window_limit(const RegisterMap& map) noexcept;
/// Errors: plan_invalid when a value does not fit the registers (position, normal, speed).
core::Status check_point(const RegisterMap& map, const PathPoint& point, std::uint64_t index, double lsb_mm);

}  // namespace cmm::drivers::modbus
