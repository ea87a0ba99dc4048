// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "sim/contact.hpp"
#include "sim/controller.hpp"

namespace cmm::sim {
namespace {

constexpr double lift_off_mm = 2.0;      // way without contact after which a path has failed (docs/protocol-modbus.md)
constexpr double unit_tolerance = 0.01;  // of a path normal's length
constexpr std::uint32_t touch_stream = 1U << 31U;  // touches draw their errors apart from path points
constexpr double edge_turning_per_mm = 0.15;  // the ball's path about an edge bends more than this, along a side less

// Until a path has shown its share of edge points, this one counts as so many points.
constexpr double usual_edge_share = 0.25;
constexpr double usual_edge_weight = 100.0;

/// 0 on a straight, towards 1 where the path bends sharply, 0.5 at `edge_turning_per_mm`.
double edge_ness(double turning_per_mm) {
    return turning_per_mm / (turning_per_mm + edge_turning_per_mm);
}

Eigen::Vector3d clipped(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const MachineSettings& machine) {
    double share = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double way = to[axis] - from[axis];
        const double end = way > 0.0 ? machine.limit_max_mm[axis] : machine.limit_min_mm[axis];
        if (std::abs(way) > std::abs(end - from[axis])) share = std::min(share, std::abs((end - from[axis]) / way));
    }
    return from + share * (to - from);
}

}  // namespace

ResultCode Controller::fault_of(std::span<const PathPoint> points) const {
    for (const PathPoint& point : points) {
        if (std::abs(point.normal.norm() - 1.0) > unit_tolerance || point.speed_mm_s <= 0.0)
            return ResultCode::path_invalid;
        if (!inside_limits(point.position)) return ResultCode::travel_limit;
    }
    return ResultCode::ok;
}

ScanPath::Append Controller::append_path(std::uint16_t id, std::uint32_t first, std::span<const PathPoint> points) {
    if (id == 0 || id != path_.id()) return ScanPath::Append::invalid;
    const ScanPath::Append outcome = path_.append(first, points);
    if (outcome != ScanPath::Append::taken) return outcome;
    if (path_fault_ == ResultCode::ok) path_fault_ = fault_of(points);
    const bool scanning = state_ == MachineState::scanning || state_ == MachineState::starved;
    if (path_fault_ != ResultCode::ok && scanning)
        brake(path_fault_);
    else if (phase_ == Phase::scan_wait)
        follow();
    return outcome;
}

Controller::Footing Controller::footing(std::uint32_t index) {
    const PathPoint& point = path_.at(index);
    const Eigen::Vector3d normal = point.normal.normalized();
    const auto ball = touch_along(*options_.part.surface, point.position, -normal, -search_mm_, search_mm_,
                                  options_.part.ball_radius_mm, warm_);
    // Without contact the servo has gone to the end of its search.
    if (!ball) return {point.position - search_mm_ * normal, normal, false};
    if (lifted_points_ > 0) {
        --lifted_points_;
        return {ball->centre + lift_mm_ * ball->normal, ball->normal, false};
    }
    return {ball->centre, ball->normal, true};
}

void Controller::on_search_end() {
    if (!leg_.contact) return finish(ResultCode::no_contact);
    next_ = footing(0);
    path_speed_ = 0.0;
    arrive();
}

void Controller::arrive() {
    const std::uint32_t index = path_passed_;
    const PathPoint point = path_.at(index);
    position_ = next_.centre;
    in_contact_ = next_.contact;
    off_surface_mm_ = next_.contact || index == 0 ? 0.0 : off_surface_mm_ + path_.step_mm(index);
    if (point.record) {
        const std::uint16_t bits = next_.contact ? 0 : quality::no_contact;
        if (!record(next_, index, bits, path_.turning_per_mm(index))) return brake(ResultCode::overflow);
    }
    ++path_passed_;
    path_.pass(index);
    if (off_surface_mm_ > lift_off_mm) return brake(ResultCode::no_contact);
    if (!point.last) return follow();
    path_ended_ = true;
    const Eigen::Vector3d away = position_ + retract_mm_ * point.normal.normalized();
    start_leg(MachineState::scanning, Phase::scan_retract, clipped(position_, away, options_.machine),
              std::min(point.speed_mm_s, options_.machine.max_speed_mm_s));
}

void Controller::follow() {
    const std::uint32_t index = path_passed_;
    if (!path_.has(index)) {
        state_ = MachineState::starved;
        phase_ = Phase::scan_wait;
        event_s_ = never;
        return;
    }
    next_ = footing(index);
    const double accel = options_.machine.max_accel_mm_s2;
    const double step = path_.step_mm(index);
    const double reachable = std::sqrt(path_speed_ * path_speed_ + 2.0 * accel * step);
    const double end_speed = std::min(path_.point_speed(index), reachable);
    leg_ =
        Leg{position_, next_.centre, Ramp(step, path_speed_, end_speed, path_.segment_speed(index), accel), now_s_, {}};
    path_speed_ = end_speed;
    // A path point at the same place as the one before it takes one tick.
    const double tick_s = path_.at(index).record ? 1.0 / options_.machine.sample_rate_hz : 0.0;
    enter(MachineState::scanning, Phase::scan_follow, std::max(leg_.ramp.duration(), tick_s));
}

void Controller::on_touch_end() {
    if (!leg_.contact) return finish(ResultCode::no_contact);
    std::size_t warm = 0;
    const Contact contact = options_.part.surface->nearest(position_, warm);
    if (!record({position_, contact.normal, true}, -1, quality::touch, 0.0)) return finish(ResultCode::overflow);
    const double length = (leg_.to - leg_.from).norm();
    const Eigen::Vector3d back = position_ + retract_mm_ / length * (leg_.from - leg_.to);
    start_leg(MachineState::touching, Phase::touch_retract, clipped(position_, back, options_.machine),
              options_.machine.max_speed_mm_s);
}

ProbeError Controller::draw_error(std::int64_t index, double turning_per_mm) {
    if (index < 0) return probe_error(probe_, path_.id(), touch_stream + touches_++, 0.0);
    const double bend = edge_ness(turning_per_mm);
    ++path_recorded_;
    path_edges_ += bend > 0.5 ? 1 : 0;
    probe_.edge_points_share =
        (path_edges_ + usual_edge_share * usual_edge_weight) / (path_recorded_ + usual_edge_weight);
    return probe_error(probe_, path_.id(), static_cast<std::uint32_t>(index), bend);
}

bool Controller::record(const Footing& at, std::int64_t index, std::uint16_t quality_bits, double turning_per_mm) {
    if (fifo_.full()) {
        overflowed_ = true;
        return false;
    }
    SampleTruth truth;
    truth.index = index;
    truth.centre_mm = at.centre;
    if (at.contact) {
        const ProbeError error = draw_error(index, turning_per_mm);
        truth.noise_mm = error.noise_mm;
        truth.bad_mm = error.bad_mm;
        if (dirty_points_ > 0) truth.bad_mm += dirt_mm_;
        dirty_points_ -= dirty_points_ > 0 ? 1 : 0;
    }
    const Eigen::Vector3d measured = at.centre + options_.part.error.at(at.centre, at.normal) +
                                     (truth.noise_mm + truth.bad_mm) * at.normal +
                                     drifted_mm() * Eigen::Vector3d::UnitX();
    FifoSample& sample = truth.sample;
    sample.path = path_.id();
    sample.time_us = std::llround(now_s_ * 1e6) + clock_jump_us_;
    for (int axis = 0; axis < 3; ++axis)
        sample.counts[static_cast<std::size_t>(axis)] = core::counts_from_mm(measured[axis], options_.machine.lsb_mm);
    sample.quality = quality_bits;
    sample.seq = fifo_.push(sample);
    if (index < 0) set_values({sample.counts[0], sample.counts[1], sample.counts[2], 0});
    if (options_.on_sample) options_.on_sample(truth);
    return true;
}

}  // namespace cmm::sim
