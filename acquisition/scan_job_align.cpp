// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that finds out where the part stands, by six datum points that are touched before the first
// section (docs/adr/0019). What is found is in the run file before anything is measured in it.
#include <algorithm>
#include <utility>

#include "acquisition/datum_touches.hpp"
#include "acquisition/event_payload.hpp"
#include "acquisition/part_frame.hpp"
#include "acquisition/scan_job.hpp"
#include "core/text.hpp"
#include "drivers/refusal.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::acquisition {
namespace {

constexpr double beside_datum_mm = 1.0;  // so far beside the line of its touch a probe may stand that was left there

std::string datum_text(const Plan& plan, std::size_t touch) {
    const auto& at = plan.datum_touches[touch].centre_mm;
    return datum_touch_name(plan.datum_middles, touch) + " (ball at x " + core::fixed(at.x(), 3) + ", y " +
           core::fixed(at.y(), 3) + ", z " + core::fixed(at.z(), 3) + " mm)";
}

}  // namespace

/// Before anything moves: a machine that cannot touch, or that a person moves, does not get as far as that.
core::Status ScanJob::can_align() const {
    if (plan_.datum_touches.empty() || !capabilities_.recorded_frame.empty()) return {};
    if (!capabilities_.moves)
        return drivers::refuse("a person moves this machine: it cannot be aligned by six datum points");
    if (!capabilities_.touches)
        return drivers::refuse("this machine cannot take single touches: it cannot be aligned by six datum points");
    return {};
}

ScanJob::Step ScanJob::align() {
    if (plan_.datum_touches.empty() || frame_) co_return core::Status{};
    // The touches of a recording are played with the section behind them; what they found then holds.
    auto frame = frame_from_numbers(capabilities_.recorded_frame);
    if (capabilities_.recorded_frame.empty()) frame = co_await find_frame();
    if (!frame) co_return tl::unexpected(std::move(frame.error()));
    auto keep = [this, numbers = frame_numbers(**frame)] { return journal_->set_part_frame(numbers); };
    if (auto status = co_await workers_.run(std::move(keep)); !status) co_return status;
    use_frame(**frame);
    events_.emit(EventKind::part_aligned, 0.0, frame_payload(*frame_));
    notice("aligned " + part_frame_words(*frame_));
    co_return within_travel();
}

/// All that follows is of the part as it stands. Told of nothing else before the first section.
void ScanJob::use_frame(const PartFrame& frame) {
    frame_ = with_errors(frame, request_.part.uncertainty.errors());
    machine_.set_frame(core::MachineFromPart(frame.machine_from_part));
    came_from_.reset();
    for (auto& setup : setups_)
        take_frame(setup, *frame_);
}

boost::asio::awaitable<core::Result<std::optional<PartFrame>>> ScanJob::find_frame() {
    const double radius_mm = request_.part.stylus.radius_mm;
    fitting::SixPointRounds rounds(points_touched(plan_.datum_touches, plan_.datum_middles, radius_mm), radius_mm,
                                   request_.part.alignment.six_points->options);
    double approach_mm = plan_.datum_approach_mm;
    for (bool done = false; !done;) {
        machine_.set_frame(core::MachineFromPart(rounds.frame().machine_from_part));
        came_from_.reset();
        auto centres = co_await touch_datums(approach_mm);
        if (!centres) {
            core::Error error = std::move(centres.error());
            error.with_context("in round " + std::to_string(rounds.frame().rounds + 1) + " of the six-point alignment");
            co_return tl::unexpected(std::move(error));
        }
        for (auto& centre : *centres)
            centre = rounds.frame().machine_from_part * centre;
        const auto taken = rounds.take(*centres);
        if (!taken) {
            core::Error error = taken.error();
            error.motion = core::Motion::stopped;
            co_return tl::unexpected(std::move(error));
        }
        done = *taken;
        // The part is known now to a fraction of what it has just moved: no need to search from far away again.
        const double near_mm = std::max(plan_.approach_mm, 2.0 * rounds.frame().moved_mm);
        approach_mm = std::min(plan_.datum_approach_mm, near_mm);
        progress("six-point alignment, round " + std::to_string(rounds.frame().rounds) + ": touched " +
                 core::length_text(rounds.frame().largest_residual_mm()) + " off at most");
    }
    // None of these touches may still wait in the controller when a section begins that is measured by touches as well.
    if (auto drained = co_await machine_.drain(*intake_); !drained) co_return tl::unexpected(drained.error());
    if (auto kept = co_await drivers::until_durable(*intake_); !kept) co_return tl::unexpected(kept.error());
    co_return std::optional<PartFrame>(rounds.frame());
}

/// The ball centres in contact, where the part is believed to stand.
boost::asio::awaitable<core::Result<fitting::TouchCentres>> ScanJob::touch_datums(double approach_mm) {
    const TouchReach reach{approach_mm, plan_.datum_search_mm};
    fitting::TouchCentres centres;
    for (std::size_t i = 0; i < plan_.datum_touches.size(); ++i) {
        const drivers::PathPoint place = plan_.datum_touches[i];
        const auto where = co_await ready();
        if (!where) co_return tl::unexpected(where.error());
        auto find = [this, from = *where, to = above(place, approach_mm)] { return travel_route(plan_, from, to); };
        const auto route = co_await workers_.run(std::move(find));
        if (route.empty()) {
            co_return core::fail(core::ErrorCode::plan_invalid, "no free way to " + datum_text(plan_, i),
                                 core::Motion::stopped);
        }
        Eigen::Vector3d from = *where;
        for (const auto& point : route) {
            if (stop_requested_)
                co_return core::fail(core::ErrorCode::cancelled, "stopped on request", core::Motion::stopped);
            if (auto moved = co_await travel(from, point); !moved) {
                core::Error error = std::move(moved.error());
                error.with_context("on the way to " + datum_text(plan_, i));
                co_return tl::unexpected(std::move(error));
            }
            from = point;
        }
        came_from_ = from;
        const auto found = co_await touch(place, reach, *intake_);
        if (auto kept = co_await drivers::until_durable(*intake_); !kept) co_return tl::unexpected(kept.error());
        if (!found) {
            core::Error error = found.error();
            error.with_context("at " + datum_text(plan_, i));
            co_return tl::unexpected(std::move(error));
        }
        centres.push_back(*found);
        ++datums_touched_;
        progress("six-point alignment: " + datum_touch_name(plan_.datum_middles, i) + " touched");
    }
    co_return centres;
}

/// The plan was checked where the part was expected; now it is known where it stands.
core::Status ScanJob::within_travel() const {
    for (const auto& path : plan_.paths) {
        for (const auto& point : path.points) {
            const Eigen::Vector3d at = frame_->machine_from_part * above(point, plan_.approach_mm);
            const bool inside = (at.array() >= capabilities_.limit_min_mm.array()).all() &&
                                (at.array() <= capabilities_.limit_max_mm.array()).all();
            if (inside) continue;
            return core::fail(core::ErrorCode::plan_invalid,
                              "as the part stands, " + section_text(path.section, path.z_mm) +
                                  " lies outside the machine's travel: at machine x " + core::fixed(at.x(), 3) +
                                  ", y " + core::fixed(at.y(), 3) + ", z " + core::fixed(at.z(), 3) + " mm",
                              core::Motion::stopped);
        }
    }
    return {};
}

/// Of a run that was cut off while it touched the datum points: the direction off the part at the one that the probe
/// stands at.
std::optional<Eigen::Vector3d> ScanJob::off_datum(const Eigen::Vector3d& where) const {
    if (frame_) return std::nullopt;
    for (const auto& place : plan_.datum_touches) {
        const Eigen::Vector3d from_place = where - place.centre_mm;
        const double along = from_place.dot(place.normal);
        const double beside = (from_place - along * place.normal).norm();
        if (beside <= plan_.datum_search_mm + beside_datum_mm && along >= -plan_.datum_search_mm &&
            along <= plan_.datum_approach_mm)
            return place.normal;
    }
    return std::nullopt;
}

}  // namespace cmm::acquisition
