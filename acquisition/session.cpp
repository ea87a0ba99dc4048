// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session.hpp"

#include <array>

namespace cmm::acquisition {
namespace {

struct Transition {
    SessionState state;
    SessionInput input;
    SessionState next;
    SessionAction action;
};

using enum SessionState;
using In = SessionInput;
using Do = SessionAction;

constexpr std::array table{
    Transition{idle, In::start, connecting, Do::connect},
    Transition{connecting, In::succeeded, recovering, Do::recover},
    Transition{recovering, In::succeeded, homing, Do::home},
    Transition{homing, In::succeeded, qualifying, Do::qualify},
    Transition{qualifying, In::succeeded, aligning, Do::align},
    Transition{aligning, In::succeeded, approaching, Do::approach},
    Transition{approaching, In::succeeded, scanning, Do::scan},
    Transition{approaching, In::no_path_left, flushing, Do::flush},
    Transition{scanning, In::succeeded, approaching, Do::approach},

    Transition{recovering, In::held, holding, Do::wait},
    Transition{homing, In::held, holding, Do::wait},
    Transition{qualifying, In::held, holding, Do::wait},
    Transition{aligning, In::held, holding, Do::wait},
    Transition{approaching, In::held, holding, Do::wait},
    Transition{scanning, In::held, holding, Do::wait},
    Transition{flushing, In::held, holding, Do::wait},
    Transition{holding, In::succeeded, recovering, Do::recover},

    Transition{connecting, In::failed, stopping, Do::stop_machine},
    Transition{recovering, In::failed, stopping, Do::stop_machine},
    Transition{homing, In::failed, stopping, Do::stop_machine},
    Transition{qualifying, In::failed, stopping, Do::stop_machine},
    Transition{aligning, In::failed, stopping, Do::stop_machine},
    Transition{approaching, In::failed, stopping, Do::stop_machine},
    Transition{scanning, In::failed, stopping, Do::stop_machine},
    Transition{holding, In::failed, stopping, Do::stop_machine},

    Transition{idle, In::stop_requested, ended, Do::report},
    Transition{connecting, In::stop_requested, stopping, Do::stop_machine},
    Transition{recovering, In::stop_requested, stopping, Do::stop_machine},
    Transition{homing, In::stop_requested, stopping, Do::stop_machine},
    Transition{qualifying, In::stop_requested, stopping, Do::stop_machine},
    Transition{aligning, In::stop_requested, stopping, Do::stop_machine},
    Transition{approaching, In::stop_requested, stopping, Do::stop_machine},
    Transition{scanning, In::stop_requested, stopping, Do::stop_machine},
    Transition{holding, In::stop_requested, stopping, Do::stop_machine},

    Transition{stopping, In::succeeded, flushing, Do::flush},
    Transition{stopping, In::failed, flushing, Do::flush},
    Transition{flushing, In::succeeded, ended, Do::report},
    Transition{flushing, In::failed, ended, Do::report},
};

constexpr std::array<std::string_view, session_state_count> state_names{
    "idle",        "connecting", "recovering", "homing",   "qualifying", "aligning",
    "approaching", "scanning",   "stopping",   "flushing", "holding",    "ended"};
constexpr std::array<std::string_view, session_input_count> input_names{"start", "succeeded", "no_path_left",
                                                                        "held",  "failed",    "stop_requested"};

}  // namespace

SessionStep step(SessionState state, SessionInput input) noexcept {
    for (const auto& row : table) {
        if (row.state == state && row.input == input) return {row.next, row.action, true};
    }
    return {state, SessionAction::none, false};
}

std::string_view to_string(SessionState state) noexcept {
    return state_names[static_cast<std::size_t>(state)];
}
std::string_view to_string(SessionInput input) noexcept {
    return input_names[static_cast<std::size_t>(input)];
}

bool may_move(SessionState state) noexcept {
    return state == homing || state == qualifying || state == aligning || state == approaching || state == scanning ||
           state == stopping || state == holding;
}

}  // namespace cmm::acquisition
