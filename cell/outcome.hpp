// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/error.hpp"

/// What a PLC hears of a part: a result and its reason, as numbers that never change their meaning (docs/cell.md).
namespace cmm::cell {

enum class CellResult : std::uint16_t {
    none = 0,
    accepted = 1,
    rejected = 2,
    undecided = 3,
    error = 4,     ///< there is no verdict
    measured = 5,  ///< completely; the part file requires nothing
};

enum class Reason : std::uint16_t {
    none = 0,
    conforming = 1,
    out_of_tolerance = 2,
    out_while_measuring = 3,  ///< certain before the part was measured to its end
    undecided = 10,           ///< uncertainty too large, or something was not evaluable
    no_program = 100,         ///< there is no part file of this number
    program_invalid = 101,    ///< its part file cannot be used
    no_part = 102,            ///< start without part present
    serial_invalid = 103,     ///< other characters than printable ASCII, or " or a backslash
    aborted = 200,            ///< the PLC asked for it
    part_removed = 201,       ///< part present went away
    plc_silent = 202,         ///< its heartbeat stood still
    stopped_at_host = 203,    ///< somebody there stopped the run
    service_stopped = 204,
    service_restarted = 205,  ///< it had been killed, or lost its power, while it was measuring
    input = 300,              ///< what went wrong with the run: 300 + n, 400 + n, ... (reason_of)
    machine = 400,
    link = 500,
    storage = 600,
    internal = 700,
};

/// A part as the PLC asked for it.
struct Order {
    std::uint32_t run = 0;      ///< counts up from 1, never twice the same
    std::uint16_t program = 0;  ///< number of a part file
    std::string serial;         ///< at most 32 characters
};

struct Outcome {
    CellResult result = CellResult::none;
    Reason reason = Reason::none;
    bool may_be_moving = false;  ///< it is not known that the machine rests
};

/// 300 to 700 and the kind of error: its own number for each code that somebody at the cell can do something about.
Reason reason_of(core::ErrorCode code) noexcept;
/// The same of its name, as events have it ("machine_door"); internal for a name that is none.
Reason reason_of(std::string_view code_name) noexcept;
/// "none", "accepted", ...
std::string_view to_string(CellResult result) noexcept;
/// A line for people, e.g. "aborted by the PLC".
std::string_view text_of(Reason reason) noexcept;

}  // namespace cmm::cell
