// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session.hpp"

#include <array>

namespace cmm::acquisition {
namespace {

struct Row {
    SessionState state;
    SessionInput input;
    SessionState next;
    SessionAction action;
};

using enum SessionState;
using In = SessionInput;
using Do = SessionAction;

constexpr std::array table{
    Row{idle, In::start, connecting, Do::connect},
    Row{connecting, In::succeeded, recovering, Do::recover},
    Row{recovering, In::succeeded, homing, Do::home},
    Row{homing, In::succeeded, qualifying, Do::qualify},
    Row{qualifying, In::succeeded, approaching, Do::approach},
    Row{approaching, In::succeeded, scanning, Do::scan},
    Row{approaching, In::no_path_left, flushing, Do::flush},
    Row{scanning, In::succeeded, approaching, Do::approach},

    Row{recovering, In::held, holding, Do::wait},
    Row{homing, In::held, holding, Do::wait},
    Row{qualifying, In::held, holding, Do::wait},
    Row{approaching, In::held, holding, Do::wait},
    Row{scanning, In::held, holding, Do::wait},
    Row{flushing, In::held, holding, Do::wait},
    Row{holding, In::succeeded, recovering, Do::recover},

    Row{connecting, In::failed, stopping, Do::stop_machine},
    Row{recovering, In::failed, stopping, Do::stop_machine},
    Row{homing, In::failed, stopping, Do::stop_machine},
    Row{qualifying, In::failed, stopping, Do::stop_machine},
    Row{approaching, In::failed, stopping, Do::stop_machine},
    Row{scanning, In::failed, stopping, Do::stop_machine},
    Row{holding, In::failed, stopping, Do::stop_machine},

    Row{idle, In::stop_requested, ended, Do::report},
    Row{connecting, In::stop_requested, stopping, Do::stop_machine},
    Row{recovering, In::stop_requested, stopping, Do::stop_machine},
    Row{homing, In::stop_requested, stopping, Do::stop_machine},
    Row{qualifying, In::stop_requested, stopping, Do::stop_machine},
    Row{approaching, In::stop_requested, stopping, Do::stop_machine},
    Row{scanning, In::stop_requested, stopping, Do::stop_machine},
    Row{holding, In::stop_requested, stopping, Do::stop_machine},

    Row{stopping, In::succeeded, flushing, Do::flush},
    Row{stopping, In::failed, flushing, Do::flush},
    Row{flushing, In::succeeded, ended, Do::report},
    Row{flushing, In::failed, ended, Do::report},
};

constexpr std::array<std::string_view, session_state_count> state_names{
    "idle",     "connecting", "recovering", "homing",  "qualifying", "approaching",
    "scanning", "stopping",   "flushing",   "holding", "ended"};
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
    return state == homing || state == qualifying || state == approaching || state == scanning || state == stopping ||
           state == holding;
}

}  // namespace cmm::acquisition
