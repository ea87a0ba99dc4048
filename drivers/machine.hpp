// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <boost/asio/awaitable.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/clock.hpp"
#include "core/error.hpp"
#include "core/sample.hpp"
#include "drivers/link_stats.hpp"
#include "drivers/machine_errors.hpp"

namespace cmm::drivers {

enum class StopKind : std::uint8_t { controlled, emergency };

enum class MachineState : std::uint8_t {
    idle,
    homing,
    moving,
    touching,
    scanning,
    starved,  ///< stands on the path in contact and waits for more path
    stopped,  ///< after a stop or the watchdog; clear_fault() leads back to idle
    fault,
    emergency,
    qualifying,
};
std::string_view to_string(MachineState state) noexcept;

/// What a controller can do and where its limits lie: data, so that plan check, command line and page stay generic.
struct Capabilities {
    std::string model, serial, firmware;
    std::uint32_t boot_id = 0;  ///< another number after each start of the controller
    bool moves = true;          ///< false: a person moves it, the host only listens (Machine::receive)
    bool scans_paths = false;
    bool touches = false;
    bool gives_deflection = false;
    bool appends_paths = false;  ///< points may be added while the path is scanned (unknown parts)
    double sample_rate_hz = 0.0;
    std::size_t fifo_depth = 0;     ///< samples
    std::size_t path_capacity = 0;  ///< path points that fit ahead of the probe
    std::size_t path_window = 0;    ///< path points of one write
    double lsb_mm = 0.0;            ///< size of a count of Sample::counts
    double deflection_lsb_mm = 0.0;
    Eigen::Vector3d limit_min_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d limit_max_mm = Eigen::Vector3d::Zero();
    double max_speed_mm_s = 0.0;
    double max_acceleration_mm_s2 = 0.0;
    double watchdog_ms = 0.0;   ///< the controller stops by itself when it hears nothing for so long
    std::string recorded_plan;  ///< hash of the only plan that it answers (a recording); empty: any
    /// Of a recording: the frame of the part that its points were measured in, as the run file keeps it.
    std::map<std::string, double> recorded_frame;
    MachineErrors recorded_errors;  ///< of a recording: of the machine that made it
};

/// The controller at one moment, path progress included.
struct MachineStatus {
    MachineState state = MachineState::idle;
    bool homed = false, qualified = false, in_contact = false, in_motion = false;
    bool owned = false;  ///< somebody owns the machine
    bool owned_by_us = false;
    std::string fault;                                      ///< empty = none
    Eigen::Vector3d position_mm = Eigen::Vector3d::Zero();  ///< ball centre
    std::uint16_t path = 0;                                 ///< under way or last scanned
    std::uint32_t path_received = 0;                        ///< points the controller has taken
    std::uint32_t path_passed = 0;                          ///< points the probe has passed
    std::uint64_t newest_sequence = 0;                      ///< newest sample, in run sequence (0 = none of this run)
    std::uint64_t acknowledged_sequence = 0;
    std::size_t fifo_level = 0;
    std::int64_t machine_time_us = 0;
};

/// Ties the sample numbers of a run to the controller's, which go on from run to run. Goes into the journal.
struct RunOrigin {
    std::uint32_t boot_id = 0;
    std::int64_t sequence_shift = 0;  ///< run sequence = controller sequence + shift
    std::uint64_t last_sequence = 0;  ///< last sample in the journal; 0 = a new run
};

/// A point of a path in millimetres, machine frame.
struct PathPoint {
    Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< where the ball centre is expected
    Eigen::Vector3d normal = Eigen::Vector3d::UnitX();    ///< unit, out of the material
    double speed_mm_s = 0.0;                              ///< towards this point
    bool record = true;                                   ///< latch a sample here
};

struct ScanPath {
    std::uint16_t id = 1;      ///< 1...65535; comes back in Sample::path
    std::size_t section = 0;   ///< of the plan; for recordings, no controller is told
    double approach_mm = 2.0;  ///< start above the first point, along its normal
    double search_mm = 1.0;    ///< how far the surface may lie beside the expected points
    double retract_mm = 2.0;   ///< back off after the last point
};

/// Where the points of a path come from: a list known beforehand, or a predictor that follows the samples.
/// Called on the machine's executor only, never after it said `last`.
class PathSource {
  public:
    virtual ~PathSource() = default;
    /// Fills the front of `room` (never empty) and returns how many; 0 = nothing yet, ask again after more samples.
    /// `last` comes in false; set it with the last point, or with 0 points when the path turns out to have ended
    /// already.
    virtual std::size_t next(std::span<PathPoint> room, bool& last) = 0;
};

/// A complete list of points, which must outlive the scan.
class PointList final : public PathSource {
  public:
    explicit PointList(std::span<const PathPoint> points) : points_(points) {}
    std::size_t next(std::span<PathPoint> room, bool& last) override;

  private:
    std::span<const PathPoint> points_;
};

/// Takes samples: each exactly once, in sequence order, gap-free. Called on the machine's executor; does
/// not wait for the disk.
class SampleSink {
  public:
    virtual ~SampleSink() = default;
    /// An error stops the machine and ends the operation with that error.
    virtual core::Status on_samples(std::span<const core::Sample> samples) = 0;
    /// The last sample that a power cut cannot take away any more: only these are acknowledged to the controller.
    virtual std::uint64_t durable_sequence() const noexcept = 0;
    /// Everything of a path was delivered: make it durable now, do not wait for more. Whether all of it is durable;
    /// does not wait (until_durable.hpp does). An error: the disk has failed.
    virtual core::Result<bool> hasten() = 0;
};

/// Takes what a machine that is moved by hand sends. Called on the machine's executor.
class HandSink : public SampleSink {
  public:
    /// A line that means nothing: shown to the person, never guessed at.
    virtual void on_garbled(std::string_view line, std::string_view why) = 0;
};

/// What a person at the host says to a machine that is moved by hand.
enum class HandSignal : std::uint8_t {
    take_point,   ///< take one where the probe is now, if the machine can be asked
    end_section,  ///< receive() ends
};

struct ScanResult {
    std::uint32_t points_passed = 0;
    std::uint64_t first_sequence = 0;  ///< 0 = no sample was taken
    std::uint64_t last_sequence = 0;
};

/// A measuring machine. Coroutines are awaited on the executor the machine was made with, which owns its state; all
/// must have ended before the machine is destroyed (call stop(), then let them end; asio cancellation is not used).
/// Only stop(), tell(), link_stats() and set_trace() may be called from any thread. One motion at a time: a second one
/// is refused (machine_busy), never queued; state() may be asked in between. Every error carries Error::motion: what is
/// known about the machine when the operation ended. Units: mm, mm/s, machine frame; every position is a ball centre.
class Machine {
  public:
    virtual ~Machine() = default;

    /// Opens the link, checks who answers and changes nothing there. Errors: transport_*, protocol_*.
    virtual boost::asio::awaitable<core::Result<Capabilities>> connect() = 0;
    /// Takes ownership and fixes the numbering. With `resume` the numbers go on after `last_sequence` and the samples
    /// that the controller still holds are kept for drain(), if it has not been restarted since; without it a new run
    /// starts at 1 and older samples in the controller are given up. The result belongs into the journal.
    virtual boost::asio::awaitable<core::Result<RunOrigin>> begin_run(std::optional<RunOrigin> resume) = 0;
    /// Gives the ownership back, so that another host need not wait for our watchdog to run out.
    virtual boost::asio::awaitable<core::Status> end_run() = 0;
    virtual boost::asio::awaitable<core::Status> home() = 0;
    virtual boost::asio::awaitable<core::Status> qualify(double ball_radius_mm) = 0;
    /// Straight free travel; touching anything is a collision (machine_fault).
    virtual boost::asio::awaitable<core::Status> move(Eigen::Vector3d centre_mm, double speed_mm_s) = 0;
    /// Straight towards `target_mm` until contact, then back by `retract_mm`. Returns the ball centre at contact; its
    /// sample goes to the sink as well. Nothing there: machine_no_contact, and no sample.
    virtual boost::asio::awaitable<core::Result<Eigen::Vector3d>> touch(Eigen::Vector3d target_mm, double speed_mm_s,
                                                                        double retract_mm, SampleSink& sink) = 0;
    /// Scans the path. Returns when it has ended and every sample is delivered, durable and acknowledged. An error of
    /// the controller is returned after the samples it still held were delivered.
    virtual boost::asio::awaitable<core::Result<ScanResult>> scan(ScanPath path, PathSource& source,
                                                                  SampleSink& sink) = 0;
    /// Where `Capabilities::moves` is false: delivers the points that a person takes, one by one, until end_section or
    /// stop(), both of which end it without an error. Other machines refuse (machine_refused).
    virtual boost::asio::awaitable<core::Result<ScanResult>> receive(ScanPath path, HandSink& sink);
    /// Any thread; means nothing to machines that move by themselves.
    virtual void tell(HandSignal /*signal*/) noexcept {}
    /// Fetches what the controller's FIFO still holds, without motion (resume). Returns the last sequence delivered in
    /// this run.
    virtual boost::asio::awaitable<core::Result<std::uint64_t>> drain(SampleSink& sink) = 0;
    virtual boost::asio::awaitable<core::Result<MachineStatus>> state() = 0;
    /// Back to idle after a stop or fault. `emergency_released`: a person has released the emergency stop.
    virtual boost::asio::awaitable<core::Status> clear_fault(bool emergency_released = false) = 0;

    /// Asks the machine to stop: any thread, any state, any number of times; emergency outranks controlled. Returns at
    /// once; the motion under way ends with `cancelled` or `machine_emergency`.
    virtual void stop(StopKind kind) noexcept = 0;

    virtual LinkStats link_stats() const = 0;
    /// Every frame as one line of hexadecimal text with time and direction, called on a thread of the driver; {} ends
    /// it.
    virtual void set_trace(std::function<void(std::string_view)> line) = 0;
};

}  // namespace cmm::drivers
