// SPDX-License-Identifier: Apache-2.0
#include "drivers/machine.hpp"

#include <algorithm>

namespace cmm::drivers {

std::string_view to_string(MachineState state) noexcept {
    switch (state) {
        case MachineState::idle:
            return "idle";
        case MachineState::homing:
            return "homing";
        case MachineState::moving:
            return "moving";
        case MachineState::touching:
            return "touching";
        case MachineState::scanning:
            return "scanning";
        case MachineState::starved:
            return "starved";
        case MachineState::stopped:
            return "stopped";
        case MachineState::fault:
            return "fault";
        case MachineState::emergency:
            return "emergency stop";
        case MachineState::qualifying:
            return "qualifying";
    }
    return "unknown";
}

boost::asio::awaitable<core::Result<ScanResult>> Machine::receive(ScanPath /*path*/, HandSink& /*sink*/) {
    co_return core::fail(core::ErrorCode::machine_refused, "this machine moves by itself: nobody takes points by hand",
                         core::Motion::stopped);
}

std::size_t PointList::next(std::span<PathPoint> room, bool& last) {
    const std::size_t count = std::min(room.size(), points_.size());
    std::copy_n(points_.begin(), count, room.begin());
    points_ = points_.subspan(count);
    last = points_.empty();
    return count;
}

}  // namespace cmm::drivers
