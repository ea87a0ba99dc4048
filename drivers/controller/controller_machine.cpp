// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/controller_machine.hpp"

#include <algorithm>
#include <boost/asio/use_awaitable.hpp>
#include <cmath>
#include <string>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "drivers/controller/session.hpp"
#include "drivers/occupied.hpp"
#include "drivers/refusal.hpp"

namespace cmm::drivers::controller {
namespace {

namespace asio = boost::asio;
using Args = std::array<std::int32_t, 8>;

constexpr std::uint32_t points_before_scan = 256;  // a quarter of a second at 1 kHz: the link may hiccup at the start
constexpr double first_points_patience_ms = 1000.0;
constexpr double shortest_pause_ms =
    0.2;  // while a path is being invented, its next points depend on the newest samples

// Where the controller has points for eight more pauses like the last, it is asked less often: each exchange costs the
// host a tenth of a millisecond, and a plant has many machines. A slow line has no pause to give away.
constexpr std::uint32_t pauses_provided_for = 8;
constexpr double longest_pause_polls = 4.0;

bool on_path(const FifoBlock& block) {
    return block.state == static_cast<std::uint16_t>(MachineState::scanning) ||
           block.state == static_cast<std::uint16_t>(MachineState::starved);
}

}  // namespace

/// A thin layer: what each operation consists of. The conversations are the session's.
class ControllerMachine final : public Machine {
  public:
    ControllerMachine(std::unique_ptr<Port> port, double poll_ms, const DriverContext& context)
        : session_(std::move(port), poll_ms, context) {}

    asio::awaitable<core::Result<Capabilities>> connect() override;
    asio::awaitable<core::Result<RunOrigin>> begin_run(std::optional<RunOrigin> resume) override;
    asio::awaitable<core::Status> end_run() override;
    asio::awaitable<core::Status> home() override;
    asio::awaitable<core::Status> qualify(double ball_radius_mm) override;
    asio::awaitable<core::Status> move(Eigen::Vector3d centre_mm, double speed_mm_s) override;
    asio::awaitable<core::Result<Eigen::Vector3d>> touch(Eigen::Vector3d target_mm, double speed_mm_s,
                                                         double retract_mm, SampleSink& sink) override;
    asio::awaitable<core::Result<ScanResult>> scan(ScanPath path, PathSource& source, SampleSink& sink) override;
    asio::awaitable<core::Result<std::uint64_t>> drain(SampleSink& sink) override;
    asio::awaitable<core::Result<MachineStatus>> state() override;
    asio::awaitable<core::Status> clear_fault(bool emergency_released) override;
    void stop(StopKind kind) noexcept override { session_.stop(kind); }
    LinkStats link_stats() const override { return session_.port().stats(); }
    void set_trace(std::function<void(std::string_view)> line) override { session_.port().set_trace(std::move(line)); }

  private:
    /// Prepares, gives the command and waits for its end.
    asio::awaitable<core::Result<StatusBlock>> command(Opcode opcode, Args args, SampleSink* sink);
    asio::awaitable<core::Status> simple_command(Opcode opcode, Args args);
    asio::awaitable<core::Status> send_first_points(PathFeed& feed);
    asio::awaitable<core::Result<StatusBlock>> begin_scan(const ScanPath& path, PathFeed& feed);
    asio::awaitable<core::Result<StatusBlock>> follow_path(StatusBlock status, PathFeed& feed, SampleSink& sink);
    asio::awaitable<core::Status> collect(SampleSink& sink);
    core::Status check_target(const Eigen::Vector3d& centre_mm, double speed_mm_s) const;
    std::int32_t counts(double mm) const { return core::counts_from_mm(mm, session_.capabilities().lsb_mm); }

    Session session_;
    bool occupied_ = false;
};

asio::awaitable<core::Result<Capabilities>> ControllerMachine::connect() {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    co_return co_await session_.open();
}

asio::awaitable<core::Result<RunOrigin>> ControllerMachine::begin_run(std::optional<RunOrigin> resume) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    co_return co_await session_.begin(resume);
}

asio::awaitable<core::Status> ControllerMachine::end_run() {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    const auto ready = co_await session_.prepare();
    if (!ready) co_return ready;
    co_return co_await session_.release();
}

asio::awaitable<core::Result<StatusBlock>> ControllerMachine::command(Opcode opcode, Args args, SampleSink* sink) {
    const auto ready = co_await session_.prepare();
    if (!ready) co_return tl::unexpected(ready.error());
    const auto given = co_await session_.give(opcode, args);
    if (!given) co_return given;
    co_return co_await session_.finish(*given, sink);
}

asio::awaitable<core::Status> ControllerMachine::simple_command(Opcode opcode, Args args) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    const auto done = co_await command(opcode, args, nullptr);
    if (!done) co_return tl::unexpected(done.error());
    co_return core::Status{};
}

asio::awaitable<core::Status> ControllerMachine::home() {
    const Args none{};
    co_return co_await simple_command(Opcode::home, none);
}

asio::awaitable<core::Status> ControllerMachine::qualify(double ball_radius_mm) {
    if (!(ball_radius_mm > 0.0 && ball_radius_mm < 100.0)) {
        co_return refuse("a ball radius of " + core::fixed(ball_radius_mm, 4) + " mm cannot be qualified");
    }
    const Args args{counts(ball_radius_mm)};
    co_return co_await simple_command(Opcode::qualify, args);
}

core::Status ControllerMachine::check_target(const Eigen::Vector3d& centre_mm, double speed_mm_s) const {
    const Capabilities& machine = session_.capabilities();
    constexpr std::array names{"x", "y", "z"};
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double value = centre_mm[axis];
        if (value >= machine.limit_min_mm[axis] && value <= machine.limit_max_mm[axis]) continue;
        return core::fail(core::ErrorCode::machine_limit,
                          "target " + std::string(names[static_cast<std::size_t>(axis)]) + " = " +
                              core::fixed(value, 3) + " mm lies outside the travel limits " +
                              core::fixed(machine.limit_min_mm[axis], 3) + " to " +
                              core::fixed(machine.limit_max_mm[axis], 3) + " mm",
                          core::Motion::stopped);
    }
    if (speed_mm_s > 0.0 && speed_mm_s <= machine.max_speed_mm_s) return {};
    return refuse("a speed of " + core::fixed(speed_mm_s, 3) + " mm/s is not within 0 to " +
                  core::fixed(machine.max_speed_mm_s, 3) + " mm/s");
}

asio::awaitable<core::Status> ControllerMachine::move(Eigen::Vector3d centre_mm, double speed_mm_s) {
    if (auto fits = check_target(centre_mm, speed_mm_s); !fits) co_return fits;
    const Args args{counts(centre_mm.x()), counts(centre_mm.y()), counts(centre_mm.z()),
                    static_cast<std::int32_t>(core::um_from_mm(speed_mm_s))};
    co_return co_await simple_command(Opcode::move, args);
}

asio::awaitable<core::Result<Eigen::Vector3d>> ControllerMachine::touch(Eigen::Vector3d target_mm, double speed_mm_s,
                                                                        double retract_mm, SampleSink& sink) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    if (auto fits = check_target(target_mm, speed_mm_s); !fits) co_return tl::unexpected(fits.error());
    const Args args{counts(target_mm.x()), counts(target_mm.y()), counts(target_mm.z()),
                    static_cast<std::int32_t>(core::um_from_mm(speed_mm_s)), counts(retract_mm)};
    const auto done = co_await command(Opcode::touch, args, &sink);
    if (!done) co_return tl::unexpected(done.error());
    const auto delivered = co_await session_.drain(sink);
    if (!delivered) co_return tl::unexpected(delivered.error());
    const double lsb_mm = session_.capabilities().lsb_mm;
    co_return Eigen::Vector3d(done->values[0] * lsb_mm, done->values[1] * lsb_mm, done->values[2] * lsb_mm);
}

asio::awaitable<core::Result<ScanResult>> ControllerMachine::scan(ScanPath path, PathSource& source, SampleSink& sink) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    if (path.id == 0) co_return refuse("path id 0 is not used");
    PathFeed feed(session_.port(), session_.capabilities(), path.id, source);
    const std::uint64_t before = session_.reader().last_delivered();
    const auto begun = co_await begin_scan(path, feed);
    if (!begun) co_return tl::unexpected(begun.error());
    const auto ended = co_await follow_path(*begun, feed, sink);
    if (!ended) co_return tl::unexpected(ended.error());
    // Also after a fault of the controller its samples are worth having; the fault is reported first.
    const auto collected = co_await collect(sink);
    if (const auto failed = Session::failure(*ended)) co_return tl::unexpected(*failed);
    if (!collected) co_return tl::unexpected(collected.error());
    ScanResult result;
    result.points_passed = ended->path_passed;
    result.last_sequence = session_.reader().last_delivered();
    if (result.last_sequence > before) result.first_sequence = before + 1;
    co_return result;
}

asio::awaitable<core::Result<StatusBlock>> ControllerMachine::begin_scan(const ScanPath& path, PathFeed& feed) {
    const auto ready = co_await session_.prepare();
    if (!ready) co_return tl::unexpected(ready.error());
    const Args begin{path.id};
    const auto room = co_await session_.give(Opcode::path_begin, begin);
    if (!room) co_return room;
    const auto sent = co_await send_first_points(feed);
    if (!sent) co_return tl::unexpected(sent.error());
    const Args args{path.id, counts(path.approach_mm), counts(path.search_mm), counts(path.retract_mm)};
    co_return co_await session_.give(Opcode::scan, args);
}

asio::awaitable<core::Status> ControllerMachine::send_first_points(PathFeed& feed) {
    const double give_up_ms = session_.port().now_ms() + first_points_patience_ms;
    core::Status sent;
    while (sent && feed.taken() < points_before_scan) {
        const auto some = co_await session_.send_windows(feed, points_before_scan);
        if (!some) {
            sent = tl::unexpected(some.error());
        } else if (*some) {
            continue;
        } else if (feed.taken() > 0) {
            break;
        } else if (!feed.refused()) {
            sent = core::fail(core::ErrorCode::plan_invalid, "the path has no first point");
        } else if (session_.port().now_ms() > give_up_ms) {
            sent = refuse("the controller has no room for the path, though it begins");
        } else {
            co_await session_.pause(session_.poll_ms());
            feed.try_again();
        }
    }
    if (!sent && sent.error().motion == core::Motion::not_concerned) sent.error().motion = core::Motion::stopped;
    co_return sent;
}

/// The pump of a scan: windows out, samples in, and the watchdog fed, until the controller has ended the command.
asio::awaitable<core::Result<StatusBlock>> ControllerMachine::follow_path(StatusBlock status, PathFeed& feed,
                                                                          SampleSink& sink) {
    session_.begin_motion();
    const std::uint32_t newest_before = status.newest;
    const double every_ms = session_.port().status_every_ms();
    double status_due_ms = 0.0;
    double pause_ms = shortest_pause_ms;
    bool ask_status = true;
    while (session_.is_ours(status) && status.command_state == command_running) {
        const double now_ms = session_.port().now_ms();
        ask_status = ask_status || now_ms >= status_due_ms;
        if (ask_status) status_due_ms = now_ms + every_ms;
        const std::uint32_t taken = feed.taken(), passed = feed.behind_probe();
        auto block = co_await session_.exchange(&sink, &feed, ask_status);
        if (!block) {
            core::Error error = co_await session_.abandon(std::move(block.error()));
            co_return tl::unexpected(std::move(error));
        }
        if (ask_status) {
            status = session_.latest_status();
            status.path_passed = session_.port().unwrapped_passed(status.path_passed, feed.behind_probe());
            feed.passed(status.path_passed);
        }
        // Every sample is a point passed: known sooner than from the status.
        if (block->newest > newest_before) feed.passed(block->newest - newest_before);
        ask_status = !on_path(*block) || block->path_ended();
        const bool near = session_.port().now_ms() - now_ms < session_.poll_ms();
        const bool provided = near && feed.lasts(pauses_provided_for, feed.behind_probe() - passed);
        const bool at_once = block->more() || (feed.taken() != taken && !provided);
        if (provided) {
            pause_ms = std::min(2.0 * pause_ms, longest_pause_polls * session_.poll_ms());
        } else {
            pause_ms = at_once || block->count > 0 ? shortest_pause_ms : std::min(2.0 * pause_ms, session_.poll_ms());
        }
        if (at_once) continue;
        const double wait_ms = feed.complete() ? std::max(pause_ms, session_.poll_ms()) : pause_ms;
        co_await session_.pause(wait_ms);
        feed.try_again();
    }
    session_.end_motion();
    if (session_.is_ours(status)) co_return status;
    co_return core::fail(core::ErrorCode::machine_refused, "another client gave the machine a command",
                         core::Motion::may_be_moving);
}

asio::awaitable<core::Status> ControllerMachine::collect(SampleSink& sink) {
    const auto drained = co_await session_.drain(sink);
    if (!drained) co_return drained;
    co_return co_await session_.settle(sink);
}

asio::awaitable<core::Result<std::uint64_t>> ControllerMachine::drain(SampleSink& sink) {
    if (occupied_) co_return tl::unexpected(busy_error());
    const Occupied occupied(occupied_);
    const auto ready = co_await session_.prepare();
    if (!ready) co_return tl::unexpected(ready.error());
    const auto collected = co_await collect(sink);
    if (!collected) co_return tl::unexpected(collected.error());
    co_return session_.reader().last_delivered();
}

asio::awaitable<core::Result<MachineStatus>> ControllerMachine::state() {
    const auto block = co_await session_.status();
    if (!block) co_return tl::unexpected(block.error());
    const double lsb_mm = session_.capabilities().lsb_mm;
    MachineStatus status;
    status.state = static_cast<MachineState>(block->state);
    status.homed = block->homed();
    status.qualified = block->qualified();
    status.in_contact = block->in_contact();
    status.in_motion = block->in_motion();
    status.owned = block->owner != 0;
    status.owned_by_us = block->owner == session_.owner();
    if (block->fault != 0) status.fault = error_of_result(block->fault).message;
    status.position_mm = Eigen::Vector3d(block->position[0], block->position[1], block->position[2]) * lsb_mm;
    status.path = block->path;
    status.path_received = block->path_received;
    status.path_passed = block->path_passed;
    status.newest_sequence = session_.reader().run_sequence(block->newest);
    status.acknowledged_sequence = session_.reader().run_sequence(block->acknowledged);
    status.fifo_level = block->fifo_level;
    status.machine_time_us = block->time_us;
    co_return status;
}

asio::awaitable<core::Status> ControllerMachine::clear_fault(bool emergency_released) {
    const Args args{emergency_released ? 1 : 0};
    co_return co_await simple_command(Opcode::clear_fault, args);
}

std::unique_ptr<Machine> make_controller_machine(std::unique_ptr<Port> port, double poll_ms,
                                                 const DriverContext& context) {
    return std::make_unique<ControllerMachine>(std::move(port), poll_ms, context);
}

}  // namespace cmm::drivers::controller
