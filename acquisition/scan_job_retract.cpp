// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that moves the probe back, slowly, after it ran into something or was bent too far: along the
// way that it came, or along the normal of the part where it was following it.
#include <algorithm>
#include <span>
#include <utility>

#include "acquisition/scan_job.hpp"
#include "acquisition/section_start.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

// Slow enough that a probe that catches on something is stopped before it breaks; a millimetre takes half a second.
constexpr double retract_speed_mm_s = 2.0;
constexpr double nowhere_mm = 1e-3;

tl::unexpected<core::Error> stays(std::string why) {
    return core::fail(core::ErrorCode::machine_refused, std::move(why), core::Motion::stopped);
}

}  // namespace

/// The controller stands in a fault after contact: nothing else gives these codes at rest with the references known.
boost::asio::awaitable<bool> ScanJob::ran_into_something(const core::Error& error) {
    const bool contact =
        error.code == core::ErrorCode::machine_fault || error.code == core::ErrorCode::machine_deflection;
    if (!contact || error.motion != core::Motion::stopped || !owner_ || !capabilities_.moves) co_return false;
    const auto now = co_await machine_.state();
    co_return now && now->state == drivers::MachineState::fault && !now->in_motion;
}

/// Moves the probe back if that can be done, and says in the error what became of it.
boost::asio::awaitable<void> ScanJob::back_off(core::Error& error) {
    const auto distance_mm = co_await retract();
    if (distance_mm) {
        error.with_context("the probe was moved back " + core::fixed(*distance_mm, 3) + " mm");
    } else {
        error.with_context("the probe was not moved back: " + distance_mm.error().message);
        const core::Motion motion = distance_mm.error().motion;
        if (motion == core::Motion::may_be_moving || motion == core::Motion::unknown) error.motion = motion;
    }
    notice(error.context.back());
}

/// How far it was moved, mm.
boost::asio::awaitable<core::Result<double>> ScanJob::retract() {
    const auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    if (!now->homed) co_return stays("the machine has no references");
    const auto target = way_back(now->position_mm);
    if (!target) co_return stays("no way is known to be free");
    if (stop_requested_) co_return stays("stopped on request");
    const auto cleared = co_await machine_.clear_fault();
    if (!cleared) co_return tl::unexpected(cleared.error());
    // A stop that the controller heard before the fault was cleared has been cleared with it.
    if (stop_requested_) co_return stays("stopped on request");
    const double distance_mm = (*target - now->position_mm).norm();
    notice("moving the probe back " + core::fixed(distance_mm, 3) + " mm");
    auto moved = co_await machine_.move(*target, std::min(retract_speed_mm_s, plan_.approach_speed_mm_s));
    if (moved) co_return distance_mm;
    core::Error error = std::move(moved.error());
    if (error.motion != core::Motion::stopped) co_return tl::unexpected(std::move(error));
    const auto stands = co_await machine_.state();
    const double gone_mm = stands ? (stands->position_mm - now->position_mm).norm() : 0.0;
    if (gone_mm > nowhere_mm) {
        error.message =
            "only " + core::fixed(gone_mm, 3) + " of " + core::fixed(distance_mm, 3) + " mm, " + error.message;
    }
    co_return tl::unexpected(std::move(error));
}

std::optional<Eigen::Vector3d> ScanJob::way_back(const Eigen::Vector3d& where) const {
    const bool measured_some = left_over_ && left_over_->points().size() > restored_[section_].size();
    const bool on_part = state_ == SessionState::scanning && (measured_some || done_[section_]);
    if (on_part) {
        const auto& scan = request_.part.scan;
        const double near_mm = request_.part.stylus.radius_mm + scan.approach_mm + scan.search_mm;
        const auto points =
            measured_some ? std::span<const RecordedPoint>(left_over_->points()) : std::span<const RecordedPoint>();
        const auto outward = way_off(setups_[section_], points, where.head<2>(), near_mm);
        if (!outward) return std::nullopt;
        return where + scan.approach_mm * Eigen::Vector3d(outward->x(), outward->y(), 0.0);
    }
    if (!came_from_) return std::nullopt;
    const Eigen::Vector3d back = *came_from_ - where;
    const double length_mm = back.norm();
    if (length_mm < nowhere_mm) return std::nullopt;
    return where + std::min(1.0, request_.part.scan.clearance_mm / length_mm) * back;
}

}  // namespace cmm::acquisition
