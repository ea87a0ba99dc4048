// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "drivers/machine.hpp"
#include "drivers/until_durable.hpp"
#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {

/// A machine without a wire that measures a part known by its outline in every plane: follows commands at once,
/// numbers its samples like a controller, keeps those that nobody fetched, and fails where a test wants it to. One
/// thread, but for stop().
class FakeMachine final : public drivers::Machine {
  public:
    template <class T>
    using Awaitable = boost::asio::awaitable<core::Result<T>>;
    using Status = boost::asio::awaitable<core::Status>;
    /// The ball centre in contact at a path point; nothing: no contact.
    using Contact = std::function<std::optional<Eigen::Vector3d>(const drivers::PathPoint&)>;

    explicit FakeMachine(const core::Clock& clock) : clock_(clock) {
        caps.model = "Fake";
        caps.serial = "1";
        caps.scans_paths = caps.touches = caps.appends_paths = true;
        caps.sample_rate_hz = 1000.0;
        caps.fifo_depth = 4096;
        caps.path_capacity = 1024;
        caps.path_window = 16;
        caps.lsb_mm = test_lsb_mm;
        caps.limit_min_mm = {-200.0, -200.0, -50.0};
        caps.limit_max_mm = {200.0, 200.0, 300.0};
        caps.max_speed_mm_s = 200.0;
        caps.max_acceleration_mm_s2 = 1000.0;
        status.position_mm = {0.0, 0.0, 200.0};
    }

    // What the test sets.
    drivers::Capabilities caps;
    drivers::MachineStatus status;
    std::string fail_at;          ///< the call that fails ...
    std::size_t fail_number = 1;  ///< ... when it comes for this time
    core::ErrorCode fail_code = core::ErrorCode::transport_closed;
    core::Motion fail_motion = core::Motion::not_concerned;
    bool fail_in_fault = false;  ///< a move that fails with machine_fault is a collision on the way
    std::size_t cut_after = 0;   ///< the link breaks after so many scanned samples (0: never) ...
    std::size_t cut_keeps = 0;   ///< ... and so many more wait in the controller
    core::ErrorCode cut_code = core::ErrorCode::transport_closed;  ///< or what else ends the path there, at rest
    std::size_t cut_touch = 0;  ///< at this touch the link breaks, its sample waits in the controller
    std::function<void(std::size_t scanned)> on_scanned;
    std::function<void(const std::string& call)> on_call;
    Contact contact = [](const drivers::PathPoint& point) { return std::optional(point.centre_mm); };

    // What the test reads.
    std::vector<std::string> calls;
    std::vector<Eigen::Vector3d> moves;
    std::size_t stops = 0;
    std::uint64_t delivered = 0;
    std::optional<drivers::RunOrigin> resumed_from;

    std::size_t count(const std::string& call) const {
        return static_cast<std::size_t>(std::count(calls.begin(), calls.end(), call));
    }

    Awaitable<drivers::Capabilities> connect() override {
        if (auto failed = enter("connect"); !failed) co_return tl::unexpected(failed.error());
        co_return caps;
    }
    Awaitable<drivers::RunOrigin> begin_run(std::optional<drivers::RunOrigin> resume) override {
        if (auto failed = enter("begin_run"); !failed) co_return tl::unexpected(failed.error());
        resumed_from = resume;
        if (resume) co_return *resume;
        sequence_ = 0;
        kept_.clear();
        co_return drivers::RunOrigin{77, 0, 0};
    }
    Status end_run() override { co_return enter("end_run"); }
    Status home() override {
        if (auto failed = enter("home"); !failed) co_return failed;
        status.homed = true;
        co_return core::Status{};
    }
    Status qualify(double /*ball_radius_mm*/) override {
        if (auto failed = enter("qualify"); !failed) co_return failed;
        status.qualified = true;
        co_return core::Status{};
    }
    Status move(Eigen::Vector3d centre_mm, double /*speed_mm_s*/) override {
        if (auto failed = enter("move"); !failed) {
            if (fail_code == core::ErrorCode::machine_fault && fail_in_fault) {
                status.state = drivers::MachineState::fault;
                failed.error().motion = core::Motion::stopped;
                status.position_mm += 0.25 * (centre_mm - status.position_mm);
            }
            co_return failed;
        }
        if (status.state != drivers::MachineState::idle)
            co_return core::fail(core::ErrorCode::machine_refused, "not idle", core::Motion::stopped);
        moves.push_back(centre_mm);
        status.position_mm = centre_mm;
        co_return core::Status{};
    }
    Awaitable<Eigen::Vector3d> touch(Eigen::Vector3d target_mm, double /*speed_mm_s*/, double retract_mm,
                                     drivers::SampleSink& sink) override {
        if (auto failed = enter("touch"); !failed) co_return tl::unexpected(failed.error());
        const Eigen::Vector3d way = target_mm - status.position_mm;
        const Eigen::Vector3d direction = way.normalized();
        for (double gone = 0.0; gone <= way.norm(); gone += 0.05) {
            drivers::PathPoint here;
            here.centre_mm = status.position_mm + gone * direction;
            here.normal = -direction;
            const auto found = contact(here);
            if (!found || (*found - here.centre_mm).norm() > 0.1) continue;
            auto sample = next_sample(0, *found);
            sample.flags = core::sample_flag::touch;
            if (count("touch") == cut_touch) {
                kept_.push_back(sample);
                status.position_mm = *found;
                status.state = drivers::MachineState::stopped;
                co_return core::fail(core::ErrorCode::transport_closed, "the link broke", core::Motion::unknown);
            }
            if (auto taken = sink.on_samples(std::span(&sample, 1)); !taken) co_return tl::unexpected(taken.error());
            status.position_mm = *found - retract_mm * direction;
            co_return *found;
        }
        status.state = drivers::MachineState::fault;
        status.position_mm = target_mm;
        co_return core::fail(core::ErrorCode::machine_no_contact, "nothing there", core::Motion::stopped);
    }
    Awaitable<drivers::ScanResult> scan(drivers::ScanPath path, drivers::PathSource& source,
                                        drivers::SampleSink& sink) override {
        if (auto failed = enter("scan"); !failed) co_return tl::unexpected(failed.error());
        drivers::ScanResult result;
        for (bool last = false; !last;) {
            std::array<drivers::PathPoint, 16> room;
            const std::size_t given = source.next(room, last);
            for (std::size_t i = 0; i < given; ++i) {
                auto scanned = measure(path.id, room.at(i), sink);
                if (!scanned) co_return tl::unexpected(scanned.error());
                ++result.points_passed;
            }
        }
        if (auto failed = enter("retract"); !failed) co_return tl::unexpected(failed.error());
        if (auto kept = co_await drivers::until_durable(sink); !kept) co_return tl::unexpected(kept.error());
        result.last_sequence = sequence_;
        co_return result;
    }
    Awaitable<std::uint64_t> drain(drivers::SampleSink& sink) override {
        if (auto failed = enter("drain"); !failed) co_return tl::unexpected(failed.error());
        if (auto taken = sink.on_samples(kept_); !taken) co_return tl::unexpected(taken.error());
        delivered += kept_.size();
        kept_.clear();
        co_return sequence_;
    }
    Awaitable<drivers::MachineStatus> state() override {
        if (auto failed = enter("state"); !failed) co_return tl::unexpected(failed.error());
        co_return status;
    }
    Status clear_fault(bool /*emergency_released*/) override {
        if (auto failed = enter("clear_fault"); !failed) co_return failed;
        status.state = drivers::MachineState::idle;
        co_return core::Status{};
    }
    void stop(drivers::StopKind /*kind*/) noexcept override {
        ++stops;
        status.state = drivers::MachineState::stopped;
    }
    drivers::LinkStats link_stats() const override { return {}; }
    void set_trace(std::function<void(std::string_view)> /*line*/) override {}

  private:
    core::Status enter(const std::string& call) {
        calls.push_back(call);
        if (on_call) on_call(call);
        if (call == fail_at && count(call) == fail_number) return core::fail(fail_code, call + " failed", fail_motion);
        return {};
    }
    core::Sample next_sample(std::uint16_t path, const Eigen::Vector3d& centre_mm) {
        auto sample = sample_at(++sequence_, path, centre_mm);
        sample.host_time_ns = clock_.now().count();
        return sample;
    }
    core::Status measure(std::uint16_t path, const drivers::PathPoint& point, drivers::SampleSink& sink) {
        if (status.state != drivers::MachineState::idle)
            return core::fail(core::ErrorCode::cancelled, "stopped", core::Motion::stopped);
        const auto found = contact(point);
        auto sample = next_sample(path, found.value_or(point.centre_mm));
        if (!found) sample.flags = core::sample_flag::no_contact;
        status.position_mm = core::centre_mm(sample, caps.lsb_mm);
        ++scanned_;
        if (cut_after > 0 && scanned_ > cut_after) {
            kept_.push_back(sample);
            if (scanned_ < cut_after + cut_keeps) return {};
            status.state = cut_code == core::ErrorCode::machine_deflection ? drivers::MachineState::fault
                                                                           : drivers::MachineState::stopped;
            if (cut_code != core::ErrorCode::transport_closed)
                return core::fail(cut_code, "cut", core::Motion::stopped);
            return core::fail(core::ErrorCode::transport_closed, "the link broke", core::Motion::unknown);
        }
        if (auto taken = sink.on_samples(std::span(&sample, 1)); !taken) return taken;
        ++delivered;
        if (on_scanned) on_scanned(scanned_);
        return {};
    }

    const core::Clock& clock_;
    std::uint64_t sequence_ = 0;
    std::size_t scanned_ = 0;
    std::vector<core::Sample> kept_;
};

}  // namespace cmm::acquisition
