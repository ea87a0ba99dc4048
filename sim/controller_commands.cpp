// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "sim/controller.hpp"

namespace cmm::sim {
namespace {

enum Opcode : std::uint16_t {
    claim_code = 1,
    release_code,
    home_code,
    qualify_code,
    move_code,
    touch_code,
    scan_code,
    stop_code,
    clear_fault_code,
    path_begin_code
};

constexpr double radius_tolerance = 0.1;  // of the mounted ball: more is another stylus

}  // namespace

void Controller::command(const Command& command) {
    if (command.seq == last_.seq) return;
    last_ = CommandStatus{command.seq, CommandState::running, ResultCode::ok, {}};
    const ResultCode result = execute(command);
    if (result != ResultCode::ok) {
        last_.state = CommandState::failed;
        last_.result = result;
        return;
    }
    if (command.opcode != stop_code) last_fed_ = clock_.now();
    if (motion_seq_ != command.seq) last_.state = CommandState::done;
}

ResultCode Controller::execute(const Command& command) {
    if (command.opcode < claim_code || command.opcode > path_begin_code) return ResultCode::unknown_opcode;
    if (command.opcode == claim_code) return claim(command.owner);
    if (command.opcode == stop_code) {
        if (command.args[0] != 1 && command.args[0] != 2) return ResultCode::bad_argument;
        stop(static_cast<StopKind>(command.args[0]));
        return ResultCode::ok;
    }
    if (owner_ == 0 || command.owner != owner_) return ResultCode::not_owner;
    if (in_motion()) return ResultCode::busy;
    switch (command.opcode) {
        case release_code:
            owner_ = 0;
            return ResultCode::ok;
        case clear_fault_code:
            return clear_fault(command.args[0] == 1);
        case path_begin_code:
            return path_begin(command.args[0]);
        default:
            break;
    }
    if (state_ != MachineState::idle) return ResultCode::refused;
    switch (command.opcode) {
        case home_code:
            return home();
        case qualify_code:
            return qualify(command.args[0]);
        case move_code:
            return move(command);
        case touch_code:
            return touch(command);
        default:
            return scan(command);
    }
}

ResultCode Controller::claim(std::uint32_t owner) {
    if (owner == 0) return ResultCode::bad_argument;
    const bool silent = clock_.now() - last_fed_ > std::chrono::milliseconds(options_.machine.watchdog_ms);
    if (owner_ != 0 && owner_ != owner && !silent) return ResultCode::not_owner;
    owner_ = owner;
    return ResultCode::ok;
}

ResultCode Controller::clear_fault(bool release_emergency) {
    if (emergency_pressed_ && !release_emergency) return ResultCode::refused;
    if (blocked_ != ResultCode::ok) return blocked_;
    emergency_pressed_ = false;
    overflowed_ = false;
    state_ = MachineState::idle;
    fault_ = ResultCode::ok;
    return ResultCode::ok;
}

ResultCode Controller::path_begin(std::int32_t id) {
    if (id < 1 || id > 65535) return ResultCode::bad_argument;
    const MachineSettings& machine = options_.machine;
    path_.begin(static_cast<std::uint16_t>(id), machine.path_capacity,
                PathLimits{machine.max_speed_mm_s, machine.max_accel_mm_s2, 1.0 / machine.sample_rate_hz});
    path_fault_ = ResultCode::ok;
    path_passed_ = 0;
    path_recorded_ = path_edges_ = 0.0;
    path_used_ = path_ended_ = overflowed_ = false;
    lifted_points_ = 0;
    return ResultCode::ok;
}

bool Controller::inside_limits(const Eigen::Vector3d& position) const {
    return (position.array() >= options_.machine.limit_min_mm.array()).all() &&
           (position.array() <= options_.machine.limit_max_mm.array()).all();
}

Eigen::Vector3d Controller::position_argument(const Command& command) const {
    return options_.machine.lsb_mm * Eigen::Vector3d(command.args[0], command.args[1], command.args[2]);
}

double Controller::speed_argument(std::int32_t um_per_s) const {
    return std::min(um_per_s * 1e-3, options_.machine.max_speed_mm_s);
}

ResultCode Controller::home() {
    motion_seq_ = last_.seq;
    const Eigen::Vector3d above(position_.x(), position_.y(), options_.machine.home_mm.z());
    start_leg(MachineState::homing, Phase::home_up, above, options_.machine.max_speed_mm_s);
    return ResultCode::ok;
}

ResultCode Controller::qualify(std::int32_t radius_counts) {
    if (!homed_) return ResultCode::refused;
    const double mounted = options_.part.ball_radius_mm;
    if (std::abs(radius_counts * options_.machine.lsb_mm - mounted) > radius_tolerance * mounted)
        return ResultCode::bad_argument;
    motion_seq_ = last_.seq;
    enter(MachineState::qualifying, Phase::dwell, qualification_s);
    return ResultCode::ok;
}

ResultCode Controller::move(const Command& command) {
    if (!homed_) return ResultCode::refused;
    if (command.args[3] <= 0) return ResultCode::bad_argument;
    const Eigen::Vector3d target = position_argument(command);
    if (!inside_limits(target)) return ResultCode::travel_limit;
    motion_seq_ = last_.seq;
    start_leg(MachineState::moving, Phase::move, target, speed_argument(command.args[3]));
    return ResultCode::ok;
}

ResultCode Controller::touch(const Command& command) {
    if (!homed_ || !qualified_) return ResultCode::refused;
    if (command.args[3] <= 0 || command.args[4] < 0) return ResultCode::bad_argument;
    const Eigen::Vector3d target = position_argument(command);
    if (!inside_limits(target)) return ResultCode::travel_limit;
    motion_seq_ = last_.seq;
    retract_mm_ = command.args[4] * options_.machine.lsb_mm;
    start_leg(MachineState::touching, Phase::touch_search, target, speed_argument(command.args[3]));
    return ResultCode::ok;
}

ResultCode Controller::scan(const Command& command) {
    if (!homed_ || !qualified_) return ResultCode::refused;
    if (command.args[1] < 0 || command.args[2] <= 0 || command.args[3] < 0) return ResultCode::bad_argument;
    if (path_used_ || path_.received() == 0 || command.args[0] != path_.id()) return ResultCode::path_invalid;
    if (path_fault_ != ResultCode::ok) return path_fault_;
    const double lsb = options_.machine.lsb_mm;
    const Eigen::Vector3d above = path_.at(0).position + command.args[1] * lsb * path_.at(0).normal;
    if (!inside_limits(above)) return ResultCode::travel_limit;
    search_mm_ = command.args[2] * lsb;
    retract_mm_ = command.args[3] * lsb;
    path_used_ = true;
    off_surface_mm_ = 0.0;
    warm_ = 0;
    motion_seq_ = last_.seq;
    start_leg(MachineState::scanning, Phase::scan_travel, above, options_.machine.max_speed_mm_s);
    return ResultCode::ok;
}

}  // namespace cmm::sim
