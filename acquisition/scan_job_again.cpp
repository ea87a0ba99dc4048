// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that measures sections until they are decided (docs/adr/0016): when all sections are measured
// and judged by the surface through all of them, those that are undecided are measured again where that helps, pass by
// pass. A pass is planned from the recorded points alone: a run that was cut off in it plans it again, and goes on
// behind the points that are there.
#include <algorithm>
#include <utility>

#include "acquisition/event_payload.hpp"
#include "acquisition/measure_again.hpp"
#include "acquisition/scan_job.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

std::size_t points_of_pass(const std::vector<RecordedPoint>& points, std::uint8_t pass) {
    return static_cast<std::size_t>(
        std::count_if(points.begin(), points.end(), [pass](const RecordedPoint& p) { return p.pass == pass; }));
}

}  // namespace

/// Whether there is something to be measured again; then it stands at the front of again_.paths.
boost::asio::awaitable<core::Result<bool>> ScanJob::find_again() {
    const auto& bound = request_.part.scan.until_decided;
    if (!bound || !capabilities_.moves) co_return false;
    while (again_.paths.empty()) {
        finisher_->complete();
        co_await all_judged();
        if (stop_requested_) co_return true;  // the step after this one will not begin
        again_.found = false;
        auto plan = [this] { return plan_pass(); };
        if (auto status = co_await workers_.run(std::move(plan)); !status) co_return tl::unexpected(status.error());
        if (!again_.found) co_return false;
    }
    co_return true;
}

/// The next pass over all sections that need one, without what an interrupted run has measured of it already.
core::Status ScanJob::plan_pass() {
    const auto& bound = *request_.part.scan.until_decided;
    const auto pass = static_cast<std::uint8_t>(again_.pass + 1);
    for (const auto& judged : finisher_->results()) {
        const std::size_t index = judged.index;
        std::optional<AgainPass> planned;
        if (pass <= bound.passes) planned = plan_again(judged, setups_[index], plan_.paths[index], bound);
        const auto there = std::exchange(again_.there[index], {});
        if (!planned && there.empty()) continue;
        again_.found = true;
        again_.measured[index].insert(again_.measured[index].end(), there.begin(), there.end());
        bool left = false;
        if (planned) {
            events_.emit(EventKind::measure_again, 0.0, again_payload(judged, pass, *planned));
            std::size_t known = there.size();
            for (auto& stretch : planned->stretches) {
                const std::size_t first = std::min(known, stretch.size());
                known -= first;
                if (first == stretch.size()) continue;
                again_.paths.push_back({index, std::move(stretch), first});
                left = true;
            }
        }
        if (!left) submit_again(index);
    }
    if (again_.found) again_.pass = pass;
    return {};
}

void ScanJob::submit_again(std::size_t index) {
    auto live = std::make_unique<LiveSection>(setups_[index], capabilities_.lsb_mm, machine_.part_from_machine(),
                                              expected_points(index));
    live->restore(again_.measured[index]);
    finisher_->submit(std::move(live));
}

ScanJob::Step ScanJob::scan_again() {
    const auto path = next_path();
    last_path_ = path.id;
    const auto left =
        std::span<const drivers::PathPoint>(again_.paths.front().points).subspan(again_.paths.front().first);
    JournalPath entry;
    entry.path = path.id;
    entry.section = section_;
    entry.first_index = static_cast<std::uint32_t>(again_.measured[section_].size());
    entry.pass = again_.pass;
    if (auto status = co_await begin_path(entry, left.size()); !status) co_return status;
    progress(section_text(section_, setups_[section_].z_mm) + " again, pass " + std::to_string(again_.pass));
    left_over_.reset();
    auto live = std::make_unique<LiveSection>(setups_[section_], capabilities_.lsb_mm, machine_.part_from_machine(), 0);
    live->restore(again_.measured[section_]);
    live->measure_again(again_.pass, left.size());
    SampleIntake::Completed completed = [this](std::unique_ptr<LiveSection> section) {
        left_over_ = std::move(section);
    };
    intake_->begin(path.id, std::move(live), std::move(completed));
    drivers::PointList source(left);
    core::Status status;
    if (touching_) {
        status = co_await touch_planned(path.id, source);
    } else {
        const auto scanned = co_await machine_.scan(path, source, *intake_);
        if (!scanned) status = tl::unexpected(scanned.error());
    }
    if (auto unfinished = intake_->end()) left_over_ = std::move(unfinished);
    if (!status) {
        core::Error error = status.error();
        error.with_context("while measuring " + section_text(section_, setups_[section_].z_mm) + " again");
        co_return tl::unexpected(std::move(error));
    }
    again_.measured[section_] = std::exchange(left_over_, nullptr)->points();
    again_.paths.pop_front();
    if (again_.paths.empty() || again_.paths.front().section != section_) submit_again(section_);
    co_return journal_->finish_path(path.id);
}

/// What the run file holds of passes, before anything else is done with its sections.
void ScanJob::restore_again(std::vector<RecordedSection>& recorded) {
    if (!again_.paths.empty()) {  // held up in the middle of a pass
        auto& front = again_.paths.front();
        for (auto& section : recorded) {
            if (section.index != front.section) continue;
            auto& measured = again_.measured[front.section];
            front.first += points_of_pass(section.points, again_.pass) - points_of_pass(measured, again_.pass);
            front.first = std::min(front.first, front.points.size());
            measured = section.points;
        }
        return;
    }
    if (again_.pass > 0) return;
    std::uint8_t last = 0;
    for (const auto& section : recorded)
        for (const auto& point : section.points)
            last = std::max(last, point.pass);
    if (last == 0) return;
    again_.pass = static_cast<std::uint8_t>(last - 1);
    for (auto& section : recorded) {
        if (section.index >= again_.there.size()) continue;
        const auto of_last = [last](const RecordedPoint& point) { return point.pass != last; };
        const auto first = std::stable_partition(section.points.begin(), section.points.end(), of_last);
        again_.there[section.index].assign(first, section.points.end());
        section.points.erase(first, section.points.end());
    }
}

}  // namespace cmm::acquisition
