// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

/// The handshake with a PLC as a table: pure, total, without time or I/O. A thin shell (cell.hpp) performs the actions
/// and feeds back what came of them. docs/cell.md has the timing diagram.
///
///   waiting <-neutral/unready-> ready -start-> starting -recorded-> busy -ended-> recording -recorded-> done
///      ^                          | refused       | stop             | stop         ^   ^                |
///      |                          +---------------|------------------|--------------+   |   acknowledged |
///      |                                          v                  v                  |                v
///      +----- recorded ---- clearing <---------   cancelled       stopping --ended------+             clearing
///                                                     +------- recorded ----------------+
///
/// What the PLC is told of is on the disk before it is told: a start before the machine moves, a result before `done`,
/// an acknowledgement before `done` is taken back. So neither side's restart loses or doubles a part.
namespace cmm::cell {

enum class CellState : std::uint8_t {
    waiting,    ///< for a PLC that lives, with start, abort and acknowledge at 0
    ready,      ///< for a start
    starting,   ///< the start is being recorded
    cancelled,  ///< the same, but a stop has come meanwhile: the machine will not move
    busy,       ///< the part is measured
    stopping,   ///< the machine is being stopped
    recording,  ///< the result is being recorded
    done,       ///< the result stands until it is acknowledged
    clearing,   ///< the acknowledgement is being recorded
};
inline constexpr int cell_state_count = 9;

enum class CellInput : std::uint8_t {
    neutral,       ///< the PLC lives and asks for nothing
    unready,       ///< it is silent, or asks for what is not its turn
    start,         ///< a part that can be measured
    refused,       ///< a start that cannot be carried out
    recorded,      ///< what was to be kept is on the disk
    stop,          ///< abort, part gone, PLC silent, end of the service
    ended,         ///< the run is over, the machine rests as far as is known
    acknowledged,  ///< the PLC has the result
};
inline constexpr int cell_input_count = 8;

enum class CellAction : std::uint8_t { none, record_start, run, stop_run, record_result, record_cleared };

struct CellStep {
    CellState state = CellState::waiting;
    CellAction action = CellAction::none;
    bool accepted = false;  ///< false: this input means nothing in this state; the state stays
};

CellStep step(CellState state, CellInput input) noexcept;
/// "waiting", "ready", ...
std::string_view to_string(CellState state) noexcept;
/// A part has been taken on and its result is not there yet.
bool is_busy(CellState state) noexcept;
/// The result stands in the registers.
bool is_done(CellState state) noexcept;

}  // namespace cmm::cell
