// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>

#include "core/clock.hpp"
#include "sim/command.hpp"
#include "sim/machine_file.hpp"
#include "sim/probe.hpp"
#include "sim/ramp.hpp"
#include "sim/sample_fifo.hpp"
#include "sim/scan_path.hpp"
#include "sim/surface.hpp"

namespace cmm::sim {

/// The state in which a motion that ended with this result leaves the machine.
MachineState state_after(ResultCode result) noexcept;

/// What the simulator knows about a sample and a real controller does not.
struct SampleTruth {
    FifoSample sample;
    std::int64_t index = -1;  ///< path point, -1 for a touch
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
    double noise_mm = 0.0;
    double bad_mm = 0.0;
};

struct ControllerOptions {
    MachineSettings machine;
    Part part;
    double speed = 1.0;  ///< machine seconds per host second; 0: as fast as it goes
    std::uint64_t seed = 1;
    std::uint16_t boot_id = 1;
    std::function<void(const SampleTruth&)> on_sample;
    std::function<void(StopKind)> on_stop;  ///< told when a stop arrives, before it is carried out
};

/// The simulated CMM controller: takes commands and paths, moves in machine time, records samples. A discrete-event
/// machine: each motion ends with an event, and `step` runs the events that are due. The counts of a scan depend on the
/// part, the path and the seed alone, never on timing. One thread; `clock` outlives the controller. Millimetres,
/// seconds.
class Controller {
  public:
    Controller(ControllerOptions options, const core::Clock& clock);

    /// Executed once per new sequence; the outcome is in `command_status`.
    void command(const Command& command);
    void stop(StopKind kind);
    ScanPath::Append append_path(std::uint16_t id, std::uint32_t first, std::span<const PathPoint> points);
    void feed_watchdog(std::uint16_t value);
    bool acknowledge(std::uint32_t seq) { return fifo_.acknowledge(seq); }
    /// Lets the machine go on until now, at most `max_events` events; true if there is more to do at once.
    bool step(int max_events = 64);

    MachineState state() const { return state_; }
    ResultCode fault() const { return fault_; }
    const CommandStatus& command_status() const { return last_; }
    std::uint16_t flags() const;  ///< register 66
    std::uint16_t heartbeat() const { return heartbeat_; }
    std::uint32_t owner() const { return owner_; }
    Eigen::Vector3d position_mm() const;
    std::int64_t time_us() const { return time_at_us(now_s_); }
    double machine_time_s() const { return now_s_; }
    bool at_rest() const { return !in_motion(); }
    const SampleFifo& fifo() const { return fifo_; }
    const ScanPath& path() const { return path_; }
    std::uint32_t path_passed() const { return path_passed_; }
    /// Whether no more samples of this path will come.
    bool path_ended(std::uint16_t id) const { return id != path_.id() || path_ended_; }
    bool overflowed() const { return overflowed_; }
    /// Of a block of samples of a path that ends before `next`: bit 0 samples were lost, 1 more wait, 2 the path ended.
    std::uint16_t sample_flags(std::uint16_t path, std::uint32_t next) const;
    const ControllerOptions& options() const { return options_; }

    // controller_faults.cpp: what a fault plan does to the machine
    /// Ends what is under way as the controller would for this reason; the emergency stop stays pressed, a door open,
    /// a temperature out of range until `restore`.
    void break_down(ResultCode reason);
    /// The cause is gone; the state stays until CLEAR_FAULT. A machine that lost its position was led clear of the
    /// part.
    void restore(ResultCode reason);
    /// Switched off and on: position kept, references, samples, path and owner forgotten.
    void restart(std::uint16_t boot_id);
    void jump_clock(double seconds) { clock_jump_us_ += std::llround(seconds * 1e6); }
    /// From now on the part lies elsewhere.
    void shift_part(const Eigen::Vector3d& by_mm);
    /// Of the points to come: so many without contact, so many with dirt under the ball.
    void lift_off(int points, double by_mm);
    void soil(int points, double height_mm);
    /// Positions run away along x, machine time; 0 ends it where it is.
    void drift(double mm_per_s);
    /// The next requests are refused with this code.
    void refuse_next(std::uint8_t code, int times);
    /// The code that the present request is refused with; 0: none.
    std::uint8_t take_refusal();

  private:
    /// What the machine is doing; each phase ends at `event_s_`.
    enum class Phase : std::uint8_t {
        rest,
        home_up,
        home_across,
        dwell,
        move,
        touch_search,
        touch_retract,
        scan_travel,
        scan_search,
        scan_follow,
        scan_wait,
        scan_retract,
        braking
    };
    struct Leg {
        Eigen::Vector3d from = Eigen::Vector3d::Zero();
        Eigen::Vector3d to = Eigen::Vector3d::Zero();
        Ramp ramp;
        double start_s = 0.0;
        std::optional<double> contact;  ///< way at which the ball meets the part
    };
    /// Where the ball is when the probe is at a path point.
    struct Footing {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero();
        Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
        bool contact = false;
    };
    static constexpr double never = std::numeric_limits<double>::infinity();
    static constexpr double reference_search_s = 0.5;
    static constexpr double qualification_s = 1.0;

    // controller.cpp: time, motions, ends
    bool run_timed(double allowed_s, int max_events);
    bool run_free(double elapsed_s, int max_events);
    bool waits_for_room() const;
    void check_watchdog();
    bool in_motion() const { return phase_ != Phase::rest; }
    bool on_leg() const;
    void enter(MachineState state, Phase phase, double duration_s);
    void start_leg(MachineState state, Phase phase, const Eigen::Vector3d& to, double speed_mm_s);
    void end_leg();
    void on_event();
    void on_dwell_end();
    void brake(ResultCode reason);
    void finish(ResultCode result);
    void set_values(const std::array<std::int32_t, 4>& values);
    std::int64_t time_at_us(double at_s) const { return static_cast<std::int64_t>(at_s * 1e6) + clock_jump_us_; }
    double drifted_mm() const { return drift_mm_ + drift_mm_s_ * (now_s_ - drift_from_s_); }

    // controller_commands.cpp
    ResultCode execute(const Command& command);
    ResultCode claim(std::uint32_t owner);
    ResultCode clear_fault(bool release_emergency);
    ResultCode path_begin(std::int32_t id);
    ResultCode home();
    ResultCode qualify(std::int32_t radius_counts);
    ResultCode move(const Command& command);
    ResultCode touch(const Command& command);
    ResultCode scan(const Command& command);
    double speed_argument(std::int32_t um_per_s) const;
    Eigen::Vector3d position_argument(const Command& command) const;
    bool inside_limits(const Eigen::Vector3d& position) const;

    // controller_scan.cpp: touches, paths, samples
    ResultCode fault_of(std::span<const PathPoint> points) const;
    Footing footing(std::uint32_t index);
    void on_search_end();
    void arrive();
    void follow();
    void on_touch_end();
    bool record(const Footing& at, std::int64_t index, std::uint16_t quality_bits, double turning_per_mm);
    ProbeError draw_error(std::int64_t index, double turning_per_mm);

    ControllerOptions options_;
    const core::Clock& clock_;
    ProbeErrorModel probe_;
    core::Duration last_host_;
    core::Duration last_beat_;
    core::Duration last_fed_;
    std::uint16_t heartbeat_ = 0;
    std::optional<std::uint16_t> watchdog_value_;

    double now_s_ = 0.0;  // machine time
    double due_s_ = 0.0;  // machine time that the host clock has allowed so far
    double event_s_ = never;
    MachineState state_ = MachineState::idle;
    Phase phase_ = Phase::rest;
    Leg leg_;
    Eigen::Vector3d position_;  // at rest
    ResultCode fault_ = ResultCode::ok;
    ResultCode brake_reason_ = ResultCode::ok;
    bool homed_ = false, qualified_ = false, in_contact_ = false, emergency_pressed_ = false;
    std::uint32_t owner_ = 0;
    CommandStatus last_;
    std::uint16_t motion_seq_ = 0;
    double retract_mm_ = 0.0;

    SampleFifo fifo_;
    ScanPath path_;
    ResultCode path_fault_ = ResultCode::ok;
    std::uint32_t path_passed_ = 0;
    bool path_ended_ = false, path_used_ = false, overflowed_ = false;
    double search_mm_ = 0.0;
    double off_surface_mm_ = 0.0;  // way without contact
    double path_speed_ = 0.0;      // at the point passed last
    Footing next_;                 // at the point the probe is going to
    std::size_t warm_ = 0;
    std::uint32_t touches_ = 0;
    double path_recorded_ = 0.0;  // points of this path so far, and those of them at edges
    double path_edges_ = 0.0;

    ResultCode blocked_ = ResultCode::ok;  // a door or a temperature keeps the machine at rest
    std::int64_t clock_jump_us_ = 0;
    int lifted_points_ = 0, dirty_points_ = 0;
    double lift_mm_ = 0.0, dirt_mm_ = 0.0;
    double drift_mm_ = 0.0, drift_mm_s_ = 0.0, drift_from_s_ = 0.0;
    std::uint8_t refusal_ = 0;
    int refusals_left_ = 0;
};

}  // namespace cmm::sim
