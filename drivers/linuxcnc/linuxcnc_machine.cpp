// SPDX-License-Identifier: Apache-2.0
#include "drivers/linuxcnc/linuxcnc_machine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/rng.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "drivers/linuxcnc/capabilities.hpp"
#include "drivers/linuxcnc/homing.hpp"
#include "drivers/linuxcnc/motions.hpp"
#include "drivers/linuxcnc/rsh_session.hpp"
#include "drivers/occupied.hpp"
#include "drivers/refusal.hpp"

namespace cmm::drivers::linuxcnc {
namespace {

namespace asio = boost::asio;
using core::ErrorCode;
using core::Motion;
using core::Result;
using core::Status;
using Eigen::Vector3d;

constexpr double off_line_mm = 0.1;  // contact beside the line of approach: the coordinates are not what we think
constexpr double back_off_mm = 2.0;  // at a time, after a collision
constexpr double back_off_speed_mm_s = 5.0;
constexpr std::string_view touch_parameters = "#<_cmmlive> #5070 #5061 #5062 #5063";

std::string words_of(const Vector3d& point_mm) {
    return "X" + core::fixed(point_mm.x(), 6) + " Y" + core::fixed(point_mm.y(), 6) + " Z" +
           core::fixed(point_mm.z(), 6);
}

std::string feed(double speed_mm_s) {
    constexpr double seconds_per_minute = 60.0;
    return "F" + core::fixed(seconds_per_minute * speed_mm_s, 4);
}

std::string place_text(const Vector3d& point_mm) {
    return core::fixed(point_mm.x(), 3) + " " + core::fixed(point_mm.y(), 3) + " " + core::fixed(point_mm.z(), 3) +
           " mm";
}

double distance_to_line(const Vector3d& point, const Vector3d& from, const Vector3d& to) {
    const Vector3d along = (to - from).normalized();
    const Vector3d offset = point - from;
    return (offset - offset.dot(along) * along).norm();
}

bool is_halting(ErrorCode code) {
    return code == ErrorCode::machine_fault || code == ErrorCode::machine_position ||
           code == ErrorCode::machine_emergency;
}

class LinuxcncMachine final : public Machine {
  public:
    LinuxcncMachine(const LinkSettings& settings, const DriverContext& context)
        : settings_(settings),
          clock_(context.clock),
          session_(settings, context),
          touch_(static_cast<std::uint32_t>(core::Rng::keyed(context.seed, 3, 0).below(1'000'000'000U))) {}

    asio::awaitable<Result<Capabilities>> connect() override;
    asio::awaitable<Result<RunOrigin>> begin_run(std::optional<RunOrigin> resume) override;
    asio::awaitable<Status> end_run() override;
    asio::awaitable<Status> home() override;
    asio::awaitable<Status> qualify(double /*ball_radius_mm*/) override {
        co_return refuse(
            "LinuxCNC knows nothing of the stylus and cannot qualify it: touch a reference sphere and put the radius "
            "that comes out into the part file ([stylus] radius_mm)");
    }
    asio::awaitable<Status> move(Vector3d centre_mm, double speed_mm_s) override;
    asio::awaitable<Result<Vector3d>> touch(Vector3d target_mm, double speed_mm_s, double retract_mm,
                                            SampleSink& sink) override;
    asio::awaitable<Result<ScanResult>> scan(ScanPath /*path*/, PathSource& /*source*/, SampleSink& /*sink*/) override {
        co_return refuse(
            "LinuxCNC cannot scan along a path: linuxcncrsh has no stream of positions latched in time (no FIFO); it "
            "measures by single touches");
    }
    asio::awaitable<Result<std::uint64_t>> drain(SampleSink& /*sink*/) override { co_return sequence_; }
    asio::awaitable<Result<MachineStatus>> state() override;
    asio::awaitable<Status> clear_fault(bool emergency_released) override;
    void stop(StopKind kind) noexcept override { session_.stop(kind); }
    LinkStats link_stats() const override { return session_.log().stats(); }
    void set_trace(std::function<void(std::string_view)> line) override { session_.log().set_trace(std::move(line)); }

  private:
    asio::awaitable<Status> do_move(Vector3d centre_mm, double speed_mm_s);
    asio::awaitable<Status> travel(Vector3d centre_mm, double speed_mm_s);
    asio::awaitable<Status> back_off(Vector3d start_mm);
    asio::awaitable<Result<Vector3d>> do_touch(Vector3d target_mm, double speed_mm_s, double retract_mm,
                                               SampleSink& sink);
    asio::awaitable<Result<Vector3d>> search(Vector3d start_mm, Vector3d target_mm, double speed_mm_s);
    Status deliver(const Vector3d& centre_mm, SampleSink& sink);
    /// Keeps the fault that clear_fault() has to clear.
    core::Error ended(core::Error error);

    LinkSettings settings_;
    const core::Clock& clock_;
    RshSession session_;
    Motions motions_{session_};
    bool occupied_ = false;
    MachineState activity_ = MachineState::idle;
    std::string fault_;
    core::Duration begun_{};
    std::uint64_t sequence_ = 0;
    std::uint32_t touch_;
};

/// What the machine is doing, while it does.
class Activity {
  public:
    Activity(MachineState& state, MachineState now) : state_(state) { state_ = now; }
    ~Activity() { state_ = MachineState::idle; }
    Activity(const Activity&) = delete;
    Activity& operator=(const Activity&) = delete;

  private:
    MachineState& state_;
};

asio::awaitable<Result<Capabilities>> LinuxcncMachine::connect() {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    const auto open = co_await session_.open();
    if (!open) co_return tl::unexpected(open.error());
    begun_ = clock_.now();
    auto ini_file = co_await session_.get("inifile");
    if (!ini_file) co_return tl::unexpected(ini_file.error());
    co_return capabilities_of(settings_.linuxcnc, std::move(*ini_file));
}

asio::awaitable<Result<RunOrigin>> LinuxcncMachine::begin_run(std::optional<RunOrigin> resume) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    const auto taken = co_await session_.take_control();
    if (!taken) co_return tl::unexpected(taken.error());
    sequence_ = resume ? resume->last_sequence : 0;
    co_return RunOrigin{0, 0, sequence_};
}

asio::awaitable<Status> LinuxcncMachine::end_run() {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    co_return co_await session_.give_control_back();
}

core::Error LinuxcncMachine::ended(core::Error error) {
    if (is_halting(error.code)) fault_ = error.message;
    return error;
}

asio::awaitable<Status> LinuxcncMachine::home() {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    const Activity homing(activity_, MachineState::homing);
    auto done = co_await home_all_joints(session_, motions_, settings_.linuxcnc);
    if (!done) done = tl::unexpected(ended(std::move(done.error())));
    co_return done;
}

asio::awaitable<Status> LinuxcncMachine::move(Vector3d centre_mm, double speed_mm_s) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    if (auto fits = check_target(settings_.linuxcnc, centre_mm, speed_mm_s); !fits) co_return fits;
    auto done = co_await do_move(centre_mm, speed_mm_s);
    if (!done) done = tl::unexpected(ended(std::move(done.error())));
    co_return done;
}

asio::awaitable<Status> LinuxcncMachine::do_move(Vector3d centre_mm, double speed_mm_s) {
    if (!fault_.empty()) co_return refuse("there is a fault to be cleared first: " + fault_);
    const auto ready = co_await motions_.prepare();
    if (!ready) co_return ready;
    const auto start_mm = co_await session_.position_mm("abs_cmd_pos");
    if (!start_mm) co_return tl::unexpected(start_mm.error());
    const Activity moving(activity_, MachineState::moving);
    auto done = co_await travel(centre_mm, speed_mm_s);
    if (done || done.error().code != ErrorCode::machine_fault || done.error().motion != Motion::stopped) co_return done;
    core::Error error = std::move(done.error());
    const auto touching = co_await session_.get_switch("probe_value");
    if (touching && *touching) {
        const auto backed_off = co_await back_off(*start_mm);
        if (!backed_off) error.motion = backed_off.error().motion;
        error.message += backed_off ? "; the probe was drawn back by where it came from"
                                    : "; the probe is still in contact: " + backed_off.error().message;
    }
    co_return tl::unexpected(std::move(error));
}

/// A straight motion, after prepare(). That the interpreter is idle says little: it must have arrived, too.
asio::awaitable<Status> LinuxcncMachine::travel(Vector3d centre_mm, double speed_mm_s) {
    std::string code = "G53 G1 " + feed(speed_mm_s) + " " + words_of(centre_mm);
    const std::uint64_t links = session_.log().stats().reconnects;
    auto given = co_await motions_.give(std::move(code));
    if (!given) co_return given;
    Messages messages;
    const auto position = co_await motions_.arrive(centre_mm, messages);
    if (!position) co_return tl::unexpected(position.error());
    const double short_mm = (*position - centre_mm).norm();
    if (short_mm <= arrived_mm) co_return Status{};
    const bool lost = session_.log().stats().reconnects != links;
    const std::string what =
        "the move ended " + core::length_text(short_mm) + " before its target, at " + place_text(*position);
    if (lost) co_return core::fail(ErrorCode::transport_closed, what + ": the link broke meanwhile", Motion::stopped);
    // Why is not known: nothing that is still in LinuxCNC's queue may move it later.
    core::Error unexplained{ErrorCode::machine_fault, what + ", and LinuxCNC did not say why", {}, Motion::stopped};
    co_return tl::unexpected(co_await motions_.abandon(std::move(unexplained)));
}

/// Towards where it came from, until the probe is clear: that way is known to be free.
asio::awaitable<Status> LinuxcncMachine::back_off(Vector3d start_mm) {
    for (;;) {
        const auto position = co_await session_.position_mm("abs_cmd_pos");
        if (!position) co_return tl::unexpected(position.error());
        const Vector3d back = start_mm - *position;
        const double way_mm = std::min(back.norm(), back_off_mm);
        if (way_mm <= arrived_mm)
            co_return core::fail(ErrorCode::machine_fault, "also where the move began", Motion::stopped);
        const Vector3d next_mm = *position + way_mm * back.normalized();
        auto moved = co_await travel(next_mm, back_off_speed_mm_s);
        if (!moved) co_return moved;
        const auto touching = co_await session_.get_switch("probe_value");
        if (!touching) co_return tl::unexpected(touching.error());
        if (!*touching) co_return Status{};
    }
}

asio::awaitable<Result<Vector3d>> LinuxcncMachine::touch(Vector3d target_mm, double speed_mm_s, double retract_mm,
                                                         SampleSink& sink) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    if (auto fits = check_target(settings_.linuxcnc, target_mm, speed_mm_s); !fits)
        co_return tl::unexpected(fits.error());
    auto contact = co_await do_touch(target_mm, speed_mm_s, retract_mm, sink);
    if (!contact) contact = tl::unexpected(ended(std::move(contact.error())));
    co_return contact;
}

asio::awaitable<Result<Vector3d>> LinuxcncMachine::do_touch(Vector3d target_mm, double speed_mm_s, double retract_mm,
                                                            SampleSink& sink) {
    Status ready;
    if (!(retract_mm >= 0.0)) ready = refuse("the way back after a touch cannot be negative");
    if (!fault_.empty()) ready = refuse("there is a fault to be cleared first: " + fault_);
    if (ready) ready = co_await motions_.prepare();
    if (!ready) co_return tl::unexpected(ready.error());
    const auto start_mm = co_await session_.position_mm("abs_cmd_pos");
    if (!start_mm) co_return tl::unexpected(start_mm.error());
    // LinuxCNC would take it for a contact where it stands, without a word.
    const auto touching = co_await session_.get_switch("probe_value");
    if (!touching) co_return tl::unexpected(touching.error());
    if (*touching) {
        co_return core::fail(ErrorCode::machine_refused,
                             "the probe is in contact before the touch begins (or its signal is the wrong way round)",
                             Motion::stopped);
    }
    const Activity searching(activity_, MachineState::touching);
    const auto contact_mm = co_await search(*start_mm, target_mm, speed_mm_s);
    const bool missed = !contact_mm && contact_mm.error().code == ErrorCode::machine_no_contact;
    if (!contact_mm && !missed) co_return contact_mm;
    Status kept;
    if (contact_mm) kept = deliver(*contact_mm, sink);
    // Nothing there: back all the way, where nothing was on the way.
    const Vector3d back = contact_mm ? Vector3d(*start_mm - *contact_mm) : Vector3d(*start_mm - target_mm);
    const double way_mm = missed ? back.norm() : std::min(retract_mm, back.norm());
    const Vector3d clear_mm = (contact_mm ? *contact_mm : target_mm) + way_mm * back.normalized();
    const double back_speed = std::max(speed_mm_s, back_off_speed_mm_s);
    const auto clear = co_await travel(clear_mm, back_speed);
    if (!kept) co_return tl::unexpected(kept.error());
    if (!clear) co_return tl::unexpected(clear.error());
    co_return contact_mm;
}

asio::awaitable<Result<Vector3d>> LinuxcncMachine::search(Vector3d start_mm, Vector3d target_mm, double speed_mm_s) {
    const std::uint32_t touch = ++touch_;
    // A success flag that is cleared before cannot be an old one; the number tells whether this line was carried out.
    std::string code = "#<_cmmlive>=" + std::to_string(touch) + " #5070=0 G38.3 " + feed(speed_mm_s) + " " +
                       words_of(target_mm - motions_.offset_mm());
    const std::string parameters(touch_parameters);
    auto done = co_await motions_.give(std::move(code));
    if (done) done = co_await motions_.ask_report(parameters);  // printed when the motion has ended
    Messages messages;
    if (done) done = co_await motions_.finish(messages);
    if (!done) co_return tl::unexpected(done.error());
    const auto report = co_await motions_.report(parameters, messages);
    if (!report) co_return tl::unexpected(report.error());
    const auto& values = report->values;
    if (values.size() != 5) {
        co_return core::fail(ErrorCode::protocol_invalid, "LinuxCNC's report of the touch is not complete",
                             Motion::stopped);
    }
    if (values[0] != touch) {
        co_return core::fail(ErrorCode::transport_closed, "the touch was not carried out: its command was lost",
                             Motion::stopped);
    }
    const auto position = co_await session_.position_mm("abs_cmd_pos");
    if (!position) co_return tl::unexpected(position.error());
    if (values[1] == 0.0) {
        if ((*position - target_mm).norm() <= arrived_mm) {
            co_return core::fail(ErrorCode::machine_no_contact, "nothing to touch up to " + place_text(target_mm),
                                 Motion::stopped);
        }
        co_return core::fail(ErrorCode::machine_fault,
                             "the touch ended at " + place_text(*position) +
                                 " without contact and before its target, and LinuxCNC did not say why",
                             Motion::stopped);
    }
    const double seconds_late = 1e-6 * settings_.linuxcnc.latch_delay_us;
    const Vector3d approach = (target_mm - start_mm).normalized();
    const Vector3d contact_mm =
        Vector3d(values[2], values[3], values[4]) + motions_.offset_mm() - speed_mm_s * seconds_late * approach;
    if (distance_to_line(contact_mm, start_mm, target_mm) <= off_line_mm) co_return contact_mm;
    co_return core::fail(ErrorCode::protocol_invalid,
                         "LinuxCNC gives the contact " + place_text(contact_mm) +
                             ", which is not on the way of the probe: was a coordinate system changed?",
                         Motion::stopped);
}

Status LinuxcncMachine::deliver(const Vector3d& centre_mm, SampleSink& sink) {
    const auto now = clock_.now();
    core::Sample sample;
    sample.sequence = ++sequence_;
    sample.machine_time_us = std::chrono::duration_cast<std::chrono::microseconds>(now - begun_).count();
    sample.host_time_ns = now.count();
    sample.flags = core::sample_flag::touch;
    for (std::size_t axis = 0; axis < 3; ++axis)
        sample.counts.at(axis) = core::counts_from_mm(centre_mm[static_cast<Eigen::Index>(axis)], lsb_mm);
    return sink.on_samples(std::span(&sample, 1));
}

asio::awaitable<Result<MachineStatus>> LinuxcncMachine::state() {
    const auto now = co_await session_.look();
    if (!now) co_return tl::unexpected(now.error());
    const auto position = co_await session_.position_mm("abs_act_pos");
    if (!position) co_return tl::unexpected(position.error());
    const auto homed = co_await session_.homed();
    if (!homed) co_return tl::unexpected(homed.error());
    const auto touching = co_await session_.get_switch("probe_value");
    if (!touching) co_return tl::unexpected(touching.error());
    MachineStatus status;
    status.homed = *homed;
    status.qualified = true;  // there is nothing in LinuxCNC that could be
    status.in_contact = *touching;
    status.position_mm = *position;
    status.owned = status.owned_by_us = session_.in_control();
    status.newest_sequence = status.acknowledged_sequence = sequence_;
    status.machine_time_us = std::chrono::duration_cast<std::chrono::microseconds>(clock_.now() - begun_).count();
    status.in_motion = activity_ != MachineState::idle || !now->idle;
    status.fault = fault_;
    status.state = activity_;
    if (activity_ == MachineState::idle && !now->idle) status.state = MachineState::moving;
    const bool halted = session_.stop_asked() != 0 || !now->machine_on;
    if (!status.in_motion && halted) status.state = MachineState::stopped;
    if (!status.in_motion && !fault_.empty()) status.state = MachineState::fault;
    if (now->estop) status.state = MachineState::emergency;
    co_return status;
}

asio::awaitable<Status> LinuxcncMachine::clear_fault(bool emergency_released) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    if (!session_.in_control()) co_return refuse("no run has been begun on this machine");
    auto done = co_await session_.take_control();  // another client may have had it meanwhile
    if (done) done = co_await switch_on(session_, emergency_released || settings_.linuxcnc.reset_estop);
    if (done) done = co_await session_.set("abort");
    Messages old;
    if (done) done = co_await session_.collect(old);
    if (!done) co_return done;
    session_.forget_stop();
    fault_.clear();
    co_return Status{};
}

}  // namespace

Result<std::unique_ptr<Machine>> make_linuxcnc_machine(const LinkSettings& settings, const DriverContext& context) {
    if (settings.endpoint.port == 0)
        return core::fail(ErrorCode::usage, "endpoint \"" + settings.endpoint.text() + "\": port 0 is for listeners");
    return std::make_unique<LinuxcncMachine>(settings, context);
}

}  // namespace cmm::drivers::linuxcnc
