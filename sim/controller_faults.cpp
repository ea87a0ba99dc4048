// SPDX-License-Identifier: Apache-2.0
// What a fault plan does to the machine; the rest of the controller then does what it would do on a real one.
#include <memory>
#include <utility>

#include "sim/controller.hpp"

namespace cmm::sim {
namespace {

/// A surface that lies elsewhere.
class ShiftedSurface final : public Surface {
  public:
    ShiftedSurface(std::shared_ptr<const Surface> surface, Eigen::Vector3d shift_mm)
        : surface_(std::move(surface)), shift_mm_(std::move(shift_mm)) {}

    Contact nearest(const Eigen::Vector3d& centre_mm, std::size_t& warm) const override {
        Contact contact = surface_->nearest(centre_mm - shift_mm_, warm);
        contact.point += shift_mm_;
        return contact;
    }
    Box box() const override {
        const Box box = surface_->box();
        return {box.low + shift_mm_, box.high + shift_mm_};
    }

  private:
    std::shared_ptr<const Surface> surface_;
    Eigen::Vector3d shift_mm_;
};

bool stops_dead(ResultCode reason) {
    return reason == ResultCode::collision || reason == ResultCode::over_deflection;
}

}  // namespace

void Controller::break_down(ResultCode reason) {
    if (reason == ResultCode::emergency) return stop(StopKind::emergency);
    if (reason == ResultCode::door || reason == ResultCode::temperature) blocked_ = reason;
    if (reason == ResultCode::position_lost) homed_ = false;
    if (reason == ResultCode::overflow) overflowed_ = true;
    if (in_motion()) {
        if (!stops_dead(reason)) return brake(reason);
        position_ = position_mm();
        return finish(reason);
    }
    // At rest there is nothing to run into; what keeps the machine from moving holds all the same.
    const bool matters = blocked_ == reason || reason == ResultCode::position_lost;
    if (!matters || state_ != MachineState::idle) return;
    state_ = state_after(reason);
    fault_ = reason;
}

void Controller::restore(ResultCode reason) {
    if (reason == ResultCode::emergency) emergency_pressed_ = false;
    if (blocked_ == reason) blocked_ = ResultCode::ok;
    if (reason != ResultCode::position_lost || homed_ || in_motion()) return;
    position_.z() = options_.machine.home_mm.z();
    in_contact_ = false;
}

void Controller::restart(std::uint16_t boot_id) {
    position_ = position_mm();
    options_.boot_id = boot_id;
    state_ = MachineState::idle;
    phase_ = Phase::rest;
    event_s_ = never;
    drift_mm_ = drifted_mm();
    now_s_ = due_s_ = drift_from_s_ = 0.0;
    fault_ = brake_reason_ = path_fault_ = ResultCode::ok;
    homed_ = qualified_ = emergency_pressed_ = false;
    owner_ = 0;
    last_ = {};
    motion_seq_ = 0;
    watchdog_value_.reset();
    fifo_ = SampleFifo(options_.machine.fifo_depth);
    path_ = ScanPath();
    path_passed_ = 0;
    path_ended_ = path_used_ = overflowed_ = false;
}

void Controller::shift_part(const Eigen::Vector3d& by_mm) {
    options_.part.surface = std::make_shared<ShiftedSurface>(std::move(options_.part.surface), by_mm);
}

void Controller::lift_off(int points, double by_mm) {
    lifted_points_ = points;
    lift_mm_ = by_mm;
}

void Controller::soil(int points, double height_mm) {
    dirty_points_ = points;
    dirt_mm_ = height_mm;
}

void Controller::drift(double mm_per_s) {
    drift_mm_ = drifted_mm();
    drift_from_s_ = now_s_;
    drift_mm_s_ = mm_per_s;
}

void Controller::refuse_next(std::uint8_t code, int times) {
    refusal_ = code;
    refusals_left_ = times;
}

std::uint8_t Controller::take_refusal() {
    if (refusals_left_ == 0) return 0;
    --refusals_left_;
    return refusal_;
}

}  // namespace cmm::sim
