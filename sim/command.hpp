// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

/// The words that host and controller share: states, commands, results (docs/protocol-modbus.md).
namespace cmm::sim {

/// Register 64 of docs/protocol-modbus.md.
enum class MachineState : std::uint16_t {
    idle,
    homing,
    moving,
    touching,
    scanning,
    starved,
    stopped,
    fault,
    emergency,
    qualifying
};

/// The result codes of the document.
enum class ResultCode : std::uint16_t {
    ok = 0,
    unknown_opcode = 1,
    bad_argument = 3,
    refused = 4,
    busy = 5,
    travel_limit = 6,
    not_owner = 7,
    path_invalid = 8,
    no_contact = 9,
    watchdog = 10,
    overflow = 11,
    emergency = 12,
    stopped = 13,
    collision = 14,
    over_deflection = 15,
    door = 16,
    position_lost = 17,
    temperature = 18
};

enum class CommandState : std::uint16_t { none, running, done, failed };

enum class StopKind : std::uint16_t { controlled = 1, emergency = 2 };

/// What the simulated controller can do: scans paths, touches, paths may be appended while scanned.
inline constexpr std::uint16_t capability_bits = 1U | 2U | 8U;

struct Command {
    std::uint16_t seq = 0;
    std::uint16_t opcode = 0;
    std::uint32_t owner = 0;
    std::array<std::int32_t, 8> args{};
};

/// What became of the last command taken.
struct CommandStatus {
    std::uint16_t seq = 0;
    CommandState state = CommandState::none;
    ResultCode result = ResultCode::ok;
    std::array<std::int32_t, 4> values{};
};

}  // namespace cmm::sim
