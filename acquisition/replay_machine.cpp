// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay_machine.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "acquisition/recorded_machine.hpp"
#include "acquisition/recording.hpp"
#include "acquisition/replay_pace.hpp"
#include "drivers/occupied.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::acquisition {
namespace {

namespace asio = boost::asio;
using core::ErrorCode;
using core::Result;
using core::Status;
using drivers::busy_error;
using drivers::Occupied;
using Eigen::Vector3d;

constexpr std::size_t batch = 256;
constexpr std::uint64_t samples_ahead_of_disk = 1U << 16U;
constexpr double beside_line_mm = 0.05;  // a contact lies on the line that the probe went; this is for rounding
constexpr auto longest_pause = std::chrono::milliseconds(20);

/// Whether a probe that goes from one point to the other comes by.
bool on_line(const Vector3d& contact, const Vector3d& from, const Vector3d& to) {
    const double length = (to - from).norm();
    if (length <= 0.0) return false;
    const Vector3d direction = (to - from) / length;
    const double along = (contact - from).dot(direction);
    const double beside = (contact - from - along * direction).norm();
    return beside <= beside_line_mm && along >= -beside_line_mm && along <= length + beside_line_mm;
}

class ReplayMachine final : public drivers::Machine {
  public:
    ReplayMachine(const drivers::LinkSettings& settings, const drivers::DriverContext& context)
        : file_(settings.endpoint.path),
          clock_(context.clock),
          pace_(static_cast<double>(settings.endpoint.integer("speed", 0)), context.clock),
          timer_(context.executor) {}

    asio::awaitable<Result<drivers::Capabilities>> connect() override;
    asio::awaitable<Result<drivers::RunOrigin>> begin_run(std::optional<drivers::RunOrigin> resume) override;
    asio::awaitable<Status> end_run() override { co_return Status{}; }
    asio::awaitable<Status> home() override { co_return ready(); }
    asio::awaitable<Status> qualify(double /*ball_radius_mm*/) override { co_return ready(); }
    asio::awaitable<Status> move(Vector3d centre_mm, double speed_mm_s) override;
    asio::awaitable<Result<Vector3d>> touch(Vector3d target_mm, double speed_mm_s, double retract_mm,
                                            drivers::SampleSink& sink) override;
    asio::awaitable<Result<drivers::ScanResult>> scan(drivers::ScanPath path, drivers::PathSource& source,
                                                      drivers::SampleSink& sink) override;
    asio::awaitable<Result<drivers::ScanResult>> receive(drivers::ScanPath path, drivers::HandSink& sink) override;
    void tell(drivers::HandSignal signal) noexcept override;
    asio::awaitable<Result<std::uint64_t>> drain(drivers::SampleSink& sink) override;
    asio::awaitable<Result<drivers::MachineStatus>> state() override;
    asio::awaitable<Status> clear_fault(bool emergency_released) override;
    void stop(drivers::StopKind kind) noexcept override;
    drivers::LinkStats link_stats() const override;
    void set_trace(std::function<void(std::string_view)> /*line*/) override {}

  private:
    using Label = std::optional<std::uint16_t>;
    /// Whether an operation may begin.
    Status ready() const;
    /// Plays samples under the path's id, no sooner than the speed allows, no further ahead of the disk than it should.
    asio::awaitable<Status> play(std::span<const core::Sample> samples, Label path, drivers::SampleSink& sink);
    asio::awaitable<void> pause();
    asio::awaitable<Result<drivers::ScanResult>> play_path(const drivers::ScanPath& path, drivers::PathSource& source,
                                                           drivers::SampleSink& sink);

    std::string file_;
    const core::Clock& clock_;
    ReplayPace pace_;
    asio::steady_timer timer_;
    std::optional<Recording> recording_;
    drivers::Capabilities capabilities_;
    bool occupied_ = false;
    std::atomic<bool> stopped_{false}, section_ended_{false};
    std::atomic<std::uint64_t> batches_{0}, stops_{0};
    Vector3d position_mm_ = Vector3d::Zero();
    std::uint16_t path_ = 0;
    std::uint32_t passed_ = 0;
    std::int64_t machine_time_us_ = 0;
};

asio::awaitable<Result<drivers::Capabilities>> ReplayMachine::connect() {
    auto recording = Recording::load(file_);
    if (!recording) co_return tl::unexpected(recording.error());
    auto capabilities = recorded_capabilities(recording->header());
    if (!capabilities) {
        core::Error error = std::move(capabilities.error());
        error.message = file_ + ": " + error.message;
        co_return tl::unexpected(std::move(error));
    }
    capabilities->recorded_frame = recording->part_frame();
    recording_ = std::move(*recording);
    capabilities_ = std::move(*capabilities);
    position_mm_ = capabilities_.limit_max_mm;
    co_return capabilities_;
}

asio::awaitable<Result<drivers::RunOrigin>> ReplayMachine::begin_run(std::optional<drivers::RunOrigin> resume) {
    if (auto free = ready(); !free) co_return tl::unexpected(free.error());
    const auto& header = recording_->header();
    const std::uint64_t last = resume ? resume->last_sequence : 0;
    const bool same = !resume || (resume->boot_id == header.boot_id && resume->sequence_shift == header.sequence_shift);
    if (!same || last > recording_->size()) {
        co_return core::fail(ErrorCode::machine_refused, "the run to go on with was not made from " + file_,
                             core::Motion::stopped);
    }
    recording_->go_to(last);
    co_return drivers::RunOrigin{header.boot_id, header.sequence_shift, last};
}

Status ReplayMachine::ready() const {
    if (occupied_) return tl::unexpected(busy_error());
    if (stopped_) return core::fail(ErrorCode::cancelled, "stopped on request", core::Motion::stopped);
    if (!recording_) return core::fail(ErrorCode::machine_refused, "not connected", core::Motion::stopped);
    return {};
}

asio::awaitable<Status> ReplayMachine::move(Vector3d centre_mm, double /*speed_mm_s*/) {
    const auto status = ready();
    if (status) position_mm_ = centre_mm;
    co_return status;
}

asio::awaitable<void> ReplayMachine::pause() {
    timer_.expires_after(pace_.at_once() ? std::chrono::milliseconds(1) : longest_pause);
    co_await timer_.async_wait(asio::use_awaitable);
}

asio::awaitable<Status> ReplayMachine::play(std::span<const core::Sample> samples, Label path,
                                            drivers::SampleSink& sink) {
    std::vector<core::Sample> given;
    while (!samples.empty()) {
        if (stopped_) co_return core::fail(ErrorCode::cancelled, "stopped on request", core::Motion::stopped);
        const std::size_t count = pace_.due(samples.first(std::min(samples.size(), batch)));
        const bool disk_behind = recording_->position() > sink.durable_sequence() + samples_ahead_of_disk;
        if (count == 0 || disk_behind) {
            co_await pause();
            continue;
        }
        given.assign(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(count));
        for (auto& sample : given) {
            if (path) sample.path = *path;
            sample.host_time_ns = clock_.now().count();
        }
        recording_->played(count);
        ++batches_;
        machine_time_us_ = given.back().machine_time_us;
        if (auto taken = sink.on_samples(given); !taken) co_return taken;
        samples = samples.subspan(count);
    }
    co_return Status{};
}

asio::awaitable<Result<Vector3d>> ReplayMachine::touch(Vector3d target_mm, double /*speed_mm_s*/, double retract_mm,
                                                       drivers::SampleSink& sink) {
    if (auto free = ready(); !free) co_return tl::unexpected(free.error());
    const Occupied occupied(occupied_);
    const auto ahead = recording_->touches();
    std::size_t found = 0;
    // A run that was cut off between two touches holds some that the run that went on did again.
    while (found < ahead.size() &&
           !on_line(core::centre_mm(ahead[found], capabilities_.lsb_mm), position_mm_, target_mm))
        ++found;
    if (found == ahead.size()) {
        position_mm_ = target_mm;
        co_return core::fail(ErrorCode::machine_no_contact, "nothing was touched here when it was recorded",
                             core::Motion::stopped);
    }
    const Vector3d contact = core::centre_mm(ahead[found], capabilities_.lsb_mm);
    const auto played = co_await play(ahead.first(found + 1), std::nullopt, sink);
    if (!played) co_return tl::unexpected(played.error());
    position_mm_ = contact + retract_mm * (position_mm_ - target_mm).normalized();
    co_return contact;
}

asio::awaitable<Result<drivers::ScanResult>> ReplayMachine::scan(drivers::ScanPath path, drivers::PathSource& source,
                                                                 drivers::SampleSink& sink) {
    if (auto free = ready(); !free) co_return tl::unexpected(free.error());
    const Occupied occupied(occupied_);
    co_return co_await play_path(path, source, sink);
}

asio::awaitable<Result<drivers::ScanResult>> ReplayMachine::play_path(const drivers::ScanPath& path,
                                                                      drivers::PathSource& source,
                                                                      drivers::SampleSink& sink) {
    drivers::ScanResult result;
    path_ = path.id;
    passed_ = 0;
    std::array<drivers::PathPoint, batch> room;
    for (bool last = false, gap = false; !last && !gap;) {
        const std::size_t given = source.next(room, last);
        if (given == 0) {
            if (last) break;
            co_return core::fail(ErrorCode::plan_invalid, "the path gives no point though all before have a sample",
                                 core::Motion::stopped);
        }
        const auto section = recording_->next_section();
        if (section && *section < path.section) {
            co_return core::fail(ErrorCode::machine_refused,
                                 "the recording goes on with section " + std::to_string(*section) + ", section " +
                                     std::to_string(path.section) + " was asked for",
                                 core::Motion::stopped);
        }
        if (const auto before = recording_->touches(); section == path.section && !before.empty()) {
            const auto played = co_await play(before, std::nullopt, sink);
            if (!played) co_return tl::unexpected(played.error());
        }
        const auto measured = std::count_if(room.begin(), room.begin() + static_cast<std::ptrdiff_t>(given),
                                            [](const drivers::PathPoint& point) { return point.record; });
        const auto ahead = recording_->of_section(path.section);
        const auto samples = ahead.first(std::min(ahead.size(), static_cast<std::size_t>(measured)));
        gap = samples.size() < static_cast<std::size_t>(measured);
        if (!samples.empty()) {
            if (result.first_sequence == 0) result.first_sequence = samples.front().sequence;
            result.last_sequence = samples.back().sequence;
            const auto& at = room.at(gap ? samples.size() - 1 : given - 1);
            position_mm_ = at.centre_mm + path.retract_mm * at.normal;
        }
        const auto played = co_await play(samples, path.id, sink);
        if (!played) co_return tl::unexpected(played.error());
        passed_ += static_cast<std::uint32_t>(gap ? samples.size() : given);
    }
    if (auto kept = co_await drivers::until_durable(sink); !kept) co_return tl::unexpected(kept.error());
    result.points_passed = passed_;
    co_return result;
}

/// One by one: the point that closes the section is the last.
asio::awaitable<Result<drivers::ScanResult>> ReplayMachine::receive(drivers::ScanPath path, drivers::HandSink& sink) {
    if (auto free = ready(); !free) co_return tl::unexpected(free.error());
    const Occupied occupied(occupied_);
    drivers::ScanResult result;
    section_ended_ = false;
    path_ = path.id;
    for (auto ahead = recording_->of_section(path.section); !ahead.empty() && !section_ended_;
         ahead = recording_->of_section(path.section)) {
        const auto played = co_await play(ahead.first(1), path.id, sink);
        if (!played) co_return tl::unexpected(played.error());
        if (result.first_sequence == 0) result.first_sequence = ahead.front().sequence;
        result.last_sequence = ahead.front().sequence;
        passed_ = ++result.points_passed;
    }
    if (auto kept = co_await drivers::until_durable(sink); !kept) co_return tl::unexpected(kept.error());
    co_return result;
}

void ReplayMachine::tell(drivers::HandSignal signal) noexcept {
    if (signal == drivers::HandSignal::end_section) section_ended_ = true;
}

asio::awaitable<Result<std::uint64_t>> ReplayMachine::drain(drivers::SampleSink& /*sink*/) {
    if (auto free = ready(); !free) co_return tl::unexpected(free.error());
    co_return recording_->position();
}

asio::awaitable<Result<drivers::MachineStatus>> ReplayMachine::state() {
    drivers::MachineStatus status;
    status.state = stopped_ ? drivers::MachineState::stopped : drivers::MachineState::idle;
    status.homed = status.qualified = status.owned = status.owned_by_us = true;
    status.position_mm = position_mm_;
    status.path = path_;
    status.path_received = status.path_passed = passed_;
    status.newest_sequence = status.acknowledged_sequence = recording_ ? recording_->position() : 0;
    status.machine_time_us = machine_time_us_;
    co_return status;
}

asio::awaitable<Status> ReplayMachine::clear_fault(bool /*emergency_released*/) {
    stopped_ = false;
    co_return Status{};
}

void ReplayMachine::stop(drivers::StopKind /*kind*/) noexcept {
    stopped_ = true;
    ++stops_;
}

drivers::LinkStats ReplayMachine::link_stats() const {
    drivers::LinkStats stats;
    stats.ok = batches_;
    stats.stops = stops_;
    return stats;
}

}  // namespace

Result<std::unique_ptr<drivers::Machine>> make_replay_machine(const drivers::LinkSettings& settings,
                                                              const drivers::DriverContext& context) {
    return std::make_unique<ReplayMachine>(settings, context);
}

}  // namespace cmm::acquisition
