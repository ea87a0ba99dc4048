// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/port.hpp"

#include <cmath>
#include <limits>
#include <string>

#include "core/text.hpp"

namespace cmm::drivers::controller {
namespace {

core::ErrorCode code_of_result(std::uint16_t result) {
    switch (result) {
        case 5:
            return core::ErrorCode::machine_busy;
        case 3:
        case 4:
        case 7:
        case 8:
            return core::ErrorCode::machine_refused;
        case 6:
            return core::ErrorCode::machine_limit;
        case 9:
            return core::ErrorCode::machine_no_contact;
        case 14:
            return core::ErrorCode::machine_fault;
        case 10:
            return core::ErrorCode::machine_watchdog;
        case 11:
            return core::ErrorCode::machine_overflow;
        case 12:
            return core::ErrorCode::machine_emergency;
        case 13:
            return core::ErrorCode::cancelled;
        case 15:
            return core::ErrorCode::machine_deflection;
        case 16:
            return core::ErrorCode::machine_door;
        case 17:
            return core::ErrorCode::machine_position;
        case 18:
            return core::ErrorCode::machine_temperature;
        default:
            return core::ErrorCode::protocol_invalid;
    }
}

std::string text_of_result(std::uint16_t result) {
    switch (result) {
        case 1:
            return "the controller does not know the command";
        case 3:
            return "the controller refuses an argument";
        case 4:
            return "the controller refuses the command in its present state";
        case 5:
            return "another motion is under way";
        case 6:
            return "a position lies outside the travel limits";
        case 7:
            return "another client owns the machine";
        case 8:
            return "the controller finds the path invalid";
        case 9:
            return "no contact: the surface is not within the search distance";
        case 10:
            return "the controller heard nothing for its watchdog time and stopped";
        case 11:
            return "the controller's sample FIFO ran full and the path ended";
        case 12:
            return "emergency stop";
        case 13:
            return "stopped on request";
        case 14:
            return "collision: contact during free travel";
        case 15:
            return "the probe was deflected beyond its range";
        case 16:
            return "a door is open";
        case 17:
            return "the machine has lost its position";
        case 18:
            return "the temperature is out of range";
        default:
            return "the controller gave the unknown result code " + std::to_string(result);
    }
}

}  // namespace

core::Error error_of_result(std::uint16_t result) {
    return core::Error{code_of_result(result), text_of_result(result), {}, core::Motion::not_concerned};
}

core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm, double speed_step_mm_s) {
    const auto bad = [index](const std::string& what) {
        return core::fail(core::ErrorCode::plan_invalid, "path point " + std::to_string(index) + ": " + what);
    };
    const double reach_mm = std::numeric_limits<std::int32_t>::max() * lsb_mm;
    if (!(point.centre_mm.cwiseAbs().maxCoeff() < reach_mm))
        return bad("the position is not a number of the controller");
    if (!(std::abs(point.normal.norm() - 1.0) < 1e-3)) return bad("the normal is not a unit vector");
    const double steps = point.speed_mm_s / speed_step_mm_s;
    if (!(steps >= 0.5 && steps <= 65535.0)) {
        return bad("the speed " + core::fixed(point.speed_mm_s, 3) + " mm/s is not within " +
                   core::fixed(speed_step_mm_s, 3) + " to " + core::fixed(65535.0 * speed_step_mm_s, 2) + " mm/s");
    }
    return {};
}

}  // namespace cmm::drivers::controller
