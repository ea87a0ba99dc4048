// SPDX-License-Identifier: Apache-2.0
#include "sim/controller.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.hpp"
#include "sim/travel.hpp"

namespace cmm::sim {
namespace {

constexpr auto beat = std::chrono::milliseconds(10);  // the document promises 20 ms

}  // namespace

MachineState state_after(ResultCode result) noexcept {
    switch (result) {
        case ResultCode::watchdog:
        case ResultCode::stopped:
        case ResultCode::door:
        case ResultCode::temperature:
            return MachineState::stopped;
        case ResultCode::overflow:
        case ResultCode::collision:
        case ResultCode::over_deflection:
        case ResultCode::position_lost:
            return MachineState::fault;
        case ResultCode::emergency:
            return MachineState::emergency;
        default:
            return MachineState::idle;
    }
}

Controller::Controller(ControllerOptions options, const core::Clock& clock)
    : options_(std::move(options)),
      clock_(clock),
      last_host_(clock.now()),
      last_beat_(last_host_),
      last_fed_(last_host_),
      position_(options_.machine.home_mm),
      fifo_(options_.machine.fifo_depth) {
    probe_.seed = options_.seed;
    probe_.noise_mm = options_.part.noise_mm;
    probe_.bad_points_share = options_.part.bad_points_share;
}

bool Controller::step(int max_events) {
    const core::Duration now = clock_.now();
    const double elapsed_s = core::seconds(now - last_host_);
    last_host_ = now;
    if (now - last_beat_ >= beat) {
        ++heartbeat_;
        last_beat_ = now;
    }
    check_watchdog();
    return options_.speed > 0.0 ? run_timed(elapsed_s * options_.speed, max_events) : run_free(elapsed_s, max_events);
}

bool Controller::run_timed(double allowed_s, int max_events) {
    due_s_ += allowed_s;
    while (event_s_ <= due_s_) {
        if (max_events-- == 0) return true;
        now_s_ = event_s_;
        on_event();
    }
    now_s_ = due_s_;
    return false;
}

bool Controller::run_free(double elapsed_s, int max_events) {
    if (event_s_ == never) now_s_ += elapsed_s;
    while (event_s_ != never && !waits_for_room()) {
        if (max_events-- == 0) return true;
        now_s_ = event_s_;
        on_event();
    }
    return false;
}

bool Controller::waits_for_room() const {
    return fifo_.full() &&
           (phase_ == Phase::scan_follow || phase_ == Phase::scan_search || phase_ == Phase::touch_search);
}

void Controller::check_watchdog() {
    if (!in_motion() || phase_ == Phase::braking) return;
    if (clock_.now() - last_fed_ <= std::chrono::milliseconds(options_.machine.watchdog_ms)) return;
    owner_ = 0;
    brake(ResultCode::watchdog);
}

void Controller::feed_watchdog(std::uint16_t value) {
    if (watchdog_value_ == value) return;
    watchdog_value_ = value;
    last_fed_ = clock_.now();
}

std::uint16_t Controller::flags() const {
    const bool moving = in_motion() && phase_ != Phase::scan_wait;
    return static_cast<std::uint16_t>((homed_ ? 1U : 0U) | (qualified_ ? 2U : 0U) | (in_contact_ ? 4U : 0U) |
                                      (moving ? 8U : 0U) | (owner_ != 0 ? 16U : 0U));
}

std::uint16_t Controller::sample_flags(std::uint16_t path, std::uint32_t next) const {
    return static_cast<std::uint16_t>((overflowed_ ? 1U : 0U) | (fifo_.holds(next) ? 2U : 0U) |
                                      (path_ended(path) ? 4U : 0U));
}

bool Controller::on_leg() const {
    return phase_ != Phase::rest && phase_ != Phase::dwell && phase_ != Phase::scan_wait;
}

Eigen::Vector3d Controller::position_mm() const {
    if (!on_leg() || leg_.ramp.length() <= 0.0) return position_;
    const double part = leg_.ramp.distance_at(now_s_ - leg_.start_s) / leg_.ramp.length();
    return leg_.from + part * (leg_.to - leg_.from);
}

void Controller::enter(MachineState state, Phase phase, double duration_s) {
    state_ = state;
    phase_ = phase;
    event_s_ = now_s_ + duration_s;
}

void Controller::start_leg(MachineState state, Phase phase, const Eigen::Vector3d& to, double speed_mm_s) {
    const MachineSettings& machine = options_.machine;
    leg_.from = position_;
    leg_.to = to;
    leg_.start_s = now_s_;
    leg_.ramp = Ramp((to - position_).norm(), 0.0, 0.0, speed_mm_s, machine.max_accel_mm_s2);
    leg_.contact = first_contact(*options_.part.surface, position_, to, options_.part.ball_radius_mm);
    in_contact_ = false;
    enter(state, phase, leg_.contact ? leg_.ramp.time_at(*leg_.contact) : leg_.ramp.duration());
}

void Controller::end_leg() {
    const double length = (leg_.to - leg_.from).norm();
    position_ = leg_.contact && length > 0.0
                    ? Eigen::Vector3d(leg_.from + *leg_.contact / length * (leg_.to - leg_.from))
                    : leg_.to;
    in_contact_ = leg_.contact.has_value();
}

void Controller::brake(ResultCode reason) {
    if (!in_motion()) return;
    if (phase_ == Phase::braking) {
        // A stop that comes while the machine brakes for a lesser reason still leaves it stopped.
        if (state_after(brake_reason_) == MachineState::idle) brake_reason_ = reason;
        return;
    }
    const double speed = on_leg() ? leg_.ramp.speed_at(now_s_ - leg_.start_s) : 0.0;
    position_ = position_mm();
    if (speed <= 0.0) return finish(reason);
    brake_reason_ = reason;
    const double accel = options_.machine.max_accel_mm_s2;
    const double way = speed * speed / (2.0 * accel);
    const double length = (leg_.to - leg_.from).norm();
    const double end = leg_.contact.value_or(length);
    const double left = std::max(0.0, end - (position_ - leg_.from).norm());
    const Eigen::Vector3d direction =
        length > 0.0 ? Eigen::Vector3d((leg_.to - leg_.from) / length) : Eigen::Vector3d(Eigen::Vector3d::Zero());
    leg_ = Leg{position_, position_ + std::min(way, left) * direction, Ramp(way, speed, 0.0, speed, accel), now_s_, {}};
    enter(state_, Phase::braking, leg_.ramp.duration());
}

void Controller::finish(ResultCode result) {
    if (state_ == MachineState::scanning || state_ == MachineState::starved) path_ended_ = true;
    phase_ = Phase::rest;
    event_s_ = never;
    state_ = state_after(result);
    if (state_ != MachineState::idle) fault_ = result;
    if (last_.seq == motion_seq_) {
        last_.state = result == ResultCode::ok ? CommandState::done : CommandState::failed;
        last_.result = result;
    }
    motion_seq_ = 0;
}

void Controller::stop(StopKind kind) {
    if (options_.on_stop) options_.on_stop(kind);
    if (kind == StopKind::emergency) {
        emergency_pressed_ = true;
        position_ = position_mm();
        if (in_motion()) return finish(ResultCode::emergency);
        state_ = MachineState::emergency;
        fault_ = ResultCode::emergency;
    } else if (in_motion()) {
        brake(ResultCode::stopped);
    } else if (state_ == MachineState::idle) {
        state_ = MachineState::stopped;
        fault_ = ResultCode::stopped;
    }
}

void Controller::on_event() {
    const MachineSettings& machine = options_.machine;
    const bool touching = in_contact_;
    if (on_leg() && phase_ != Phase::scan_follow) end_leg();
    if (phase_ == Phase::braking) in_contact_ = touching;  // along a path it stays on the part
    switch (phase_) {
        case Phase::touch_search:
            return on_touch_end();
        case Phase::scan_search:
            return on_search_end();
        case Phase::scan_follow:
            return arrive();
        case Phase::braking:
            return finish(brake_reason_);
        case Phase::dwell:
            return on_dwell_end();
        default:
            break;
    }
    // What is left are free travels: touching the part is a collision.
    if (leg_.contact) return finish(ResultCode::collision);
    switch (phase_) {
        case Phase::home_up:
            return start_leg(MachineState::homing, Phase::home_across, machine.home_mm, machine.max_speed_mm_s);
        case Phase::home_across:
            return enter(MachineState::homing, Phase::dwell, reference_search_s);
        case Phase::scan_travel: {
            const PathPoint& first = path_.at(0);
            return start_leg(MachineState::scanning, Phase::scan_search, first.position - search_mm_ * first.normal,
                             std::min(first.speed_mm_s, machine.max_speed_mm_s));
        }
        default:
            return finish(ResultCode::ok);
    }
}

void Controller::on_dwell_end() {
    if (state_ == MachineState::homing) homed_ = true;
    if (state_ == MachineState::qualifying) {
        qualified_ = true;
        set_values({core::counts_from_mm(options_.part.ball_radius_mm, options_.machine.lsb_mm), 0, 0, 0});
    }
    finish(ResultCode::ok);
}

void Controller::set_values(const std::array<std::int32_t, 4>& values) {
    if (last_.seq == motion_seq_) last_.values = values;
}

}  // namespace cmm::sim
