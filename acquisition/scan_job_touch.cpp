// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that measures by single touches: on machines that cannot scan along a path, or on request.
// A sample is durable before the next touch begins, so that at most one waits in the controller when the host dies.
#include <algorithm>
#include <utility>

#include "acquisition/recorded_machine.hpp"
#include "acquisition/recorded_sections.hpp"
#include "acquisition/scan_job.hpp"
#include "acquisition/section_touches.hpp"
#include "acquisition/touch_way.hpp"
#include "core/text.hpp"
#include "drivers/refusal.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;

core::Status stopped_on_request() {
    return core::fail(ErrorCode::cancelled, "stopped on request", core::Motion::stopped);
}

std::string place_text(const Eigen::Vector3d& place) {
    return "x " + core::fixed(place.x(), 3) + ", y " + core::fixed(place.y(), 3) + " mm";
}

}  // namespace

/// A run goes on by touches or by scanning as it began: which places are left is told from its points by that.
core::Status ScanJob::measure_as_begun() {
    const auto& numbers = journal_->header().capabilities;
    const auto begun = numbers.find(touches_key);
    if (begun == numbers.end() || (begun->second != 0.0) == touching_) return {};
    const std::string run = request_.run_file + ": this run ";
    if (touching_ && capabilities_.scans_paths) {
        return core::fail(core::ErrorCode::usage,
                          run + "was begun by scanning: leave --touch out, or begin another run (--out) by touches");
    }
    if (touching_)
        return drivers::refuse(run + "was begun by scanning, which this machine cannot: go on with another machine");
    if (!capabilities_.touches) {
        return drivers::refuse(
            run + "was begun by single touches, which this machine cannot take: go on with another machine");
    }
    touching_ = true;
    times_ = plan_times(plan_, touching_);
    notice("going on by single touches, as the run began");
    return check();
}

std::size_t ScanJob::next_planned() const {
    const auto& planned = plan_.paths[section_].points;
    if (touching_) return next_place(planned, restored_[section_]);
    return std::min(restored_[section_].size(), planned.size());
}

/// Whose points the touches are that a controller still holds; 0: nobody's, they sought the part.
core::Result<std::uint16_t> ScanJob::path_of_touches() const {
    if (!touching_) return std::uint16_t{0};
    const auto sections = recorded_sections(*journal_);
    if (!sections) return tl::unexpected(sections.error());
    std::uint16_t path = 0;
    for (const auto& section : *sections) {
        const bool found = request_.nominal != nullptr || !section.points.empty();
        if (!section.finished && found) path = std::max(path, section.last_path);
    }
    return path;
}

ScanJob::Step ScanJob::touch_planned(std::uint16_t path, drivers::PathSource& source) {
    std::size_t missed = 0;
    const Missed note = [&missed](const drivers::PathPoint& place, std::size_t in_row) -> core::Status {
        ++missed;
        if (in_row <= most_missed_places) return {};
        return core::fail(ErrorCode::machine_no_contact,
                          "nothing to touch at " + std::to_string(in_row) + " places in a row, the last of them at " +
                              place_text(place.centre_mm),
                          core::Motion::stopped);
    };
    auto status = co_await touch_along(path, source, note);
    if (status && missed > 0)
        notice(section_text(section_, setups_[section_].z_mm) + ": " + std::to_string(missed) +
               " places without contact; the gaps are not evaluable");
    co_return status;
}

/// Place after place, each after the sample of the one before.
ScanJob::Step ScanJob::touch_along(std::uint16_t path, drivers::PathSource& source, const Missed& note) {
    SectionTouches sink(*intake_, path);
    const TouchReach reach{plan_.approach_mm, plan_.search_mm};
    drivers::PathPoint before;
    std::size_t places = 0, missed = 0;
    double proud_mm = 0.0;  // how far the last contact lay outside its place
    for (bool last = false; !last;) {
        drivers::PathPoint place;
        const std::size_t given = source.next(std::span(&place, 1), last);
        if (given == 0 && !last)
            co_return core::fail(ErrorCode::internal, "the path gives no place though all before were touched");
        if (given == 0) break;
        if (places == 0) before = place;
        for (const auto& point : way_between(before, place, plan_.approach_mm + proud_mm)) {
            if (stop_requested_) co_return stopped_on_request();
            if (auto moved = co_await machine_.move(point, plan_.approach_speed_mm_s); !moved) co_return moved;
            came_from_ = point;
        }
        const auto contact = co_await touch(place, reach, sink);
        if (auto kept = co_await drivers::until_durable(sink); !kept) co_return kept;
        if (contact) {
            missed = 0;
            proud_mm = std::clamp(place.normal.dot(*contact - place.centre_mm), 0.0, plan_.search_mm);
        } else if (contact.error().code != ErrorCode::machine_no_contact) {
            co_return tl::unexpected(contact.error());
        } else if (auto noted = note(place, ++missed); !noted) {
            co_return noted;
        }
        before = place;
        progress(section_text(section_, setups_[section_].z_mm) + ": " + std::to_string(++places) + " places touched");
    }
    const auto drained = co_await machine_.drain(sink);
    if (!drained) co_return tl::unexpected(drained.error());
    co_return co_await drivers::until_durable(sink);
}

/// From above the place, which came_from_ is. After machine_no_contact the probe is back there.
boost::asio::awaitable<core::Result<Eigen::Vector3d>> ScanJob::touch(drivers::PathPoint place, TouchReach reach,
                                                                     drivers::SampleSink& sink) {
    if (stop_requested_) co_return tl::unexpected(stopped_on_request().error());
    const double speed_mm_s = touch_speed_mm_s(plan_);
    const auto found = co_await machine_.touch(above(place, -reach.search_mm), speed_mm_s, reach.approach_mm, sink);
    if (found) came_from_ = *found + reach.approach_mm * place.normal;
    if (found || stop_requested_ || found.error().code != ErrorCode::machine_no_contact) co_return found;
    const auto where = co_await ready();
    if (!where) co_return tl::unexpected(where.error());
    // A stop that the controller heard before the fault was cleared has been cleared with it.
    if (stop_requested_) co_return tl::unexpected(stopped_on_request().error());
    const auto back = co_await machine_.move(*came_from_, plan_.approach_speed_mm_s);
    if (!back) co_return tl::unexpected(back.error());
    co_return found;
}

}  // namespace cmm::acquisition
