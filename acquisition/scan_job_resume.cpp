// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that begins a run, or goes on with one that was cut off: what the run file and the controller
// still hold, and a probe that may stand on the part.
#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <cmath>
#include <utility>

#include "acquisition/json_text.hpp"
#include "acquisition/recorded_machine.hpp"
#include "acquisition/recorded_sections.hpp"
#include "acquisition/scan_job.hpp"
#include "acquisition/section_start.hpp"
#include "acquisition/section_touches.hpp"
#include "core/text.hpp"
#include "drivers/until_durable.hpp"

namespace cmm::acquisition {

ScanJob::Step ScanJob::recover() {
    core::Status status;
    if (going_on_) {
        status = co_await take_up();
    } else if (request_.resume) {
        status = co_await resume_run();
    } else {
        status = co_await begin_run();
    }
    if (!status) co_return status;
    keep_events();
    if (std::exchange(started_, true)) co_return core::Status{};
    JsonFields fields;
    fields.add("run", request_.run_id)
        .add("part", request_.part.name)
        .add("machine", capabilities_.model)
        .add("sections", setups_.size())
        .add("ball_radius_mm", request_.part.stylus.radius_mm, 4);
    if (capabilities_.moves && request_.nominal != nullptr)
        fields.add("planned_s", times_.total_s, 1).add("alignment_s", times_.alignment_s, 1);
    events_.emit(EventKind::run_started, 0.0, fields.text());
    co_return core::Status{};
}

ScanJob::Step ScanJob::begin_run() {
    auto origin = co_await machine_.begin_run(std::nullopt);
    if (!origin) co_return tl::unexpected(origin.error());
    owner_ = true;
    if (auto status = co_await start_journal(*origin); !status) co_return status;
    intake_ = std::make_unique<SampleIntake>(*journal_, events_);
    first_durable_ = 0;
    // A stop or fault that another run ended with is not in the way of this one, once its cause is gone; but it may
    // have left the probe on the part.
    co_return co_await leave_part();
}

ScanJob::Step ScanJob::resume_run() {
    if (auto status = co_await reopen_journal(); !status) co_return status;
    co_return co_await take_up();
}

/// Goes on behind the last sample of the open run file: with what the controller still holds, and clear of the part.
ScanJob::Step ScanJob::take_up() {
    came_from_.reset();
    if (auto status = co_await drivers::until_durable(*journal_); !status) co_return status;
    const auto& header = journal_->header();
    const std::optional<drivers::RunOrigin> before =
        drivers::RunOrigin{header.boot_id, header.sequence_shift, journal_->durable_sequence()};
    auto origin = co_await machine_.begin_run(before);
    if (!origin) co_return tl::unexpected(origin.error());
    owner_ = true;
    if (origin->boot_id != header.boot_id || origin->sequence_shift != header.sequence_shift) {
        auto set = [this, now = *origin] { return journal_->set_origin(now.boot_id, now.sequence_shift); };
        if (auto status = co_await workers_.run(std::move(set)); !status) co_return status;
    }
    if (!first_durable_) first_durable_ = journal_->durable_sequence();
    samples_before_ = journal_->durable_sequence() - *first_durable_;
    intake_ = std::make_unique<SampleIntake>(*journal_, events_);
    // At rest first: a path that the killed host began must not grow behind the samples that are fetched now.
    if (const auto where = co_await ready(); !where) co_return tl::unexpected(where.error());
    const auto touched = path_of_touches();
    if (!touched) co_return tl::unexpected(touched.error());
    SectionTouches sink(*intake_, *touched);
    auto drained = co_await machine_.drain(sink);
    if (!drained) co_return tl::unexpected(drained.error());
    if (auto status = co_await drivers::until_durable(*journal_); !status) co_return status;
    if (auto status = co_await restore_sections(); !status) co_return status;
    co_return co_await leave_part();
}

ScanJob::Step ScanJob::reopen_journal() {
    auto open = [file = request_.run_file] { return Journal::open(file); };
    auto journal = co_await workers_.run(std::move(open));
    if (!journal) co_return tl::unexpected(journal.error());
    journal_ = std::move(*journal);
    auto find_last = [this] { return journal_->last_event_seq(); };
    const auto last_event = co_await workers_.run(std::move(find_last));
    if (!last_event) co_return tl::unexpected(last_event.error());
    events_.continue_after(*last_event);
    const auto& header = journal_->header();
    if (header.plan_hash != plan_.hash) {
        co_return core::fail(core::ErrorCode::config_invalid,
                             request_.run_file + ": was planned from another part file; use the part file of that run");
    }
    if (header.lsb_mm != capabilities_.lsb_mm) {
        co_return core::fail(core::ErrorCode::config_invalid,
                             request_.run_file + ": was measured in counts of " + core::fixed(header.lsb_mm * 1e6, 3) +
                                 " nm, this machine has counts of " + core::fixed(capabilities_.lsb_mm * 1e6, 3) +
                                 " nm; go on with the machine of that run");
    }
    if (auto status = measure_as_begun(); !status) co_return status;
    use_errors(recorded_errors(header));
    auto frame = [this] { return take_recorded_frame(); };
    if (auto status = co_await workers_.run(std::move(frame)); !status) co_return status;
    request_.run_id = header.run_id;
    request_.started_utc = header.started_utc;
    co_return core::Status{};
}

/// The part stands where it was found before the run was cut off.
core::Status ScanJob::take_recorded_frame() {
    if (frame_) return {};
    const auto numbers = journal_->part_frame();
    if (!numbers) return tl::unexpected(numbers.error());
    const auto frame = frame_from_numbers(*numbers);
    if (!frame) return tl::unexpected(frame.error());
    if (*frame) use_frame(**frame);
    return {};
}

ScanJob::Step ScanJob::restore_sections() {
    auto read = [this] { return recorded_sections(*journal_); };
    auto recorded = co_await workers_.run(std::move(read));
    if (!recorded) co_return tl::unexpected(recorded.error());
    std::size_t samples = 0;
    restore_again(*recorded);
    for (auto& section : *recorded) {
        if (section.index >= setups_.size()) {
            co_return core::fail(core::ErrorCode::journal_corrupt,
                                 request_.run_file + ": names a section that the plan does not have");
        }
        last_path_ = std::max(last_path_, section.last_path);
        samples += section.points.size();
        const std::size_t expected = expected_points(section.index);
        const auto of_lap = static_cast<std::size_t>(
            std::count_if(section.points.begin(), section.points.end(), [](const auto& p) { return p.pass == 0; }));
        const bool whole = done_[section.index] || (expected > 0 && of_lap >= expected);
        if (section.finished || whole) {
            // The host was cut off between the last sample and this note.
            if (!section.finished) {
                if (auto status = journal_->finish_path(section.last_path); !status) co_return status;
            }
            if (done_[section.index]) continue;  // judged before the run was held up
            auto live = std::make_unique<LiveSection>(setups_[section.index], capabilities_.lsb_mm,
                                                      machine_.part_from_machine(), expected);
            live->restore(section.points);
            section_completed(std::move(live));
        } else {
            restored_[section.index] = std::move(section.points);
        }
    }
    events_.emit(EventKind::resume, 0.0, JsonFields().add("samples", samples).add("paths", recorded->size()).text());
    co_return core::Status{};
}

/// How the machine stands, after a motion under way (that a killed host began, say) was ended and seen to end.
boost::asio::awaitable<core::Result<drivers::MachineStatus>> ScanJob::come_to_rest() {
    constexpr int most_looks = 250;
    boost::asio::steady_timer pause(co_await boost::asio::this_coro::executor);
    auto now = co_await machine_.state();
    // On a path that ran out of points it stands still, and the scan goes on all the same.
    const auto busy = [](const drivers::MachineStatus& status) {
        return status.in_motion || status.state == drivers::MachineState::scanning ||
               status.state == drivers::MachineState::starved;
    };
    if (now && busy(*now)) machine_.stop(drivers::StopKind::controlled);
    for (int look = 0; now && busy(*now) && look < most_looks; ++look) {
        pause.expires_after(std::chrono::milliseconds(20));
        co_await pause.async_wait(boost::asio::use_awaitable);
        now = co_await machine_.state();
    }
    co_return now;
}

/// Where the probe stands, with a stop or fault of before cleared so that it may move again.
boost::asio::awaitable<core::Result<Eigen::Vector3d>> ScanJob::ready() {
    const auto now = co_await come_to_rest();
    if (!now) co_return tl::unexpected(now.error());
    if (now->state == drivers::MachineState::stopped || now->state == drivers::MachineState::fault ||
        now->state == drivers::MachineState::emergency) {
        if (auto status = co_await machine_.clear_fault(); !status) co_return tl::unexpected(status.error());
    }
    co_return now->position_mm;
}

/// A run that was cut off or stopped may have left the probe on the part: back off along the normal before anything
/// else moves. The shortest way out of the box may lead along the part.
ScanJob::Step ScanJob::leave_part() {
    const auto where = co_await ready();
    if (!where) co_return tl::unexpected(where.error());
    const auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    // A stop that the controller heard before the fault was cleared has been cleared with it.
    if (stop_requested_ || !now->homed || !capabilities_.moves) co_return core::Status{};
    if (const auto off = off_datum(*where)) {
        const Eigen::Vector3d target = *where + plan_.approach_mm * *off;
        co_return co_await machine_.move(target, plan_.approach_speed_mm_s);
    }
    if (where->z() >= plan_.clearance.top_mm) co_return core::Status{};  // over the part
    const auto nearer = [z = where->z()](const SectionSetup& a, const SectionSetup& b) {
        return std::abs(a.z_mm - z) < std::abs(b.z_mm - z);
    };
    const auto index =
        static_cast<std::size_t>(std::min_element(setups_.begin(), setups_.end(), nearer) - setups_.begin());
    const auto direction = way_off(setups_[index], restored_[index], where->head<2>(),
                                   request_.part.stylus.radius_mm + request_.part.scan.approach_mm);
    if (direction) {
        Eigen::Vector3d target = *where;
        target.head<2>() += *direction * request_.part.scan.approach_mm;
        if (auto status = co_await machine_.move(target, plan_.approach_speed_mm_s); !status) co_return status;
    }
    co_return core::Status{};
}

}  // namespace cmm::acquisition
