// SPDX-License-Identifier: Apache-2.0
#include "cell/handshake.hpp"

#include <array>
#include <cstddef>

namespace cmm::cell {
namespace {

struct Row {
    CellState state;
    CellInput input;
    CellState next;
    CellAction action;
};

using enum CellState;
using In = CellInput;
using Do = CellAction;

constexpr std::array rows{
    Row{waiting, In::neutral, ready, Do::none},
    Row{ready, In::unready, waiting, Do::none},
    Row{ready, In::start, starting, Do::record_start},
    Row{ready, In::refused, recording, Do::record_result},
    Row{starting, In::recorded, busy, Do::run},
    Row{starting, In::stop, cancelled, Do::none},
    Row{cancelled, In::recorded, recording, Do::record_result},
    Row{busy, In::stop, stopping, Do::stop_run},
    Row{busy, In::ended, recording, Do::record_result},
    Row{stopping, In::ended, recording, Do::record_result},
    Row{recording, In::recorded, done, Do::none},
    Row{done, In::acknowledged, clearing, Do::record_cleared},
    Row{clearing, In::recorded, waiting, Do::none},
};

constexpr std::array<std::string_view, cell_state_count> names{"waiting",  "ready",     "starting", "cancelled", "busy",
                                                               "stopping", "recording", "done",     "clearing"};

}  // namespace

CellStep step(CellState state, CellInput input) noexcept {
    for (const auto& row : rows)
        if (row.state == state && row.input == input) return {row.next, row.action, true};
    return {state, CellAction::none, false};
}

std::string_view to_string(CellState state) noexcept {
    return names[static_cast<std::size_t>(state)];
}

bool is_busy(CellState state) noexcept {
    return state == starting || state == cancelled || state == busy || state == stopping || state == recording;
}

bool is_done(CellState state) noexcept {
    return state == done || state == clearing;
}

}  // namespace cmm::cell
