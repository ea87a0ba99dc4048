// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

/// The course of a run as a table: pure, total, without time or I/O. A thin shell (scan_job) performs the actions and
/// feeds back what came of them.
///
///                     holding: waits at rest for what may pass by itself (held) in the states from recovering on
///                        | succeeded
///                        v
///   idle -start-> connecting -> recovering -> homing -> qualifying -> aligning -> approaching <-> scanning
///                     |             |           |           |            |        |  |              |
///                     +-------------+-----------+-----------+------------+--------+  | no_path_left |
///                     | failed, stop_requested                                       v              |
///                     +----------------> stopping ------------------------------> flushing -> ended |
///                              ^--------------------------------------------------------------------+
///
/// Also the flush may be held (by a full disk) before the run ends. Every active state leads to `stopping` on a
/// failure: the machine is never left moving, and whatever was measured is flushed to the disk before the run ends.
namespace cmm::acquisition {

enum class SessionState : std::uint8_t {
    idle,
    connecting,
    recovering,
    homing,
    qualifying,
    aligning,
    approaching,
    scanning,
    stopping,
    flushing,
    holding,
    ended,
};
inline constexpr int session_state_count = 12;

enum class SessionInput : std::uint8_t { start, succeeded, no_path_left, held, failed, stop_requested };
inline constexpr int session_input_count = 6;

enum class SessionAction : std::uint8_t {
    none,
    connect,       ///< open the link, read the identity, become the owner
    recover,       ///< fetch what the controller still holds from an earlier run
    home,          ///< where needed
    qualify,       ///< where needed
    align,         ///< by datum points, where asked for and not yet done
    approach,      ///< take the next path, go to its start; answers no_path_left when there is none
    scan,          ///< measure it
    wait,          ///< at rest, until what holds the run up has passed
    stop_machine,  ///< controlled; harmless when it stands
    flush,         ///< everything durable, everything acknowledged
    report,
};

struct SessionStep {
    SessionState state = SessionState::idle;
    SessionAction action = SessionAction::none;
    bool accepted = false;  ///< false: this input means nothing in this state; the state stays
};

SessionStep step(SessionState state, SessionInput input) noexcept;
std::string_view to_string(SessionState state) noexcept;
std::string_view to_string(SessionInput input) noexcept;

/// Whether the machine may be in motion because of us in this state.
bool may_move(SessionState state) noexcept;

}  // namespace cmm::acquisition
