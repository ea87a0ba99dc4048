// SPDX-License-Identifier: Apache-2.0
// The part of a scan job that waits at rest for what may pass by itself: an open door, a temperature, a full or slow
// disk. How it is noticed, and that the run goes on as --resume would, but in the same process.
#include <algorithm>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/this_coro.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <utility>

#include "acquisition/json_text.hpp"
#include "acquisition/scan_job.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;

constexpr auto between_looks = std::chrono::milliseconds(50);  // for a stop request
constexpr int looks_a_beat = 10;                               // then it is asked again
// A disk with less would be full again in a moment; 2000 points take some 6 KB.
constexpr std::int64_t room_wanted = std::int64_t{1} << 20U;

bool of_machine(ErrorCode code) {
    return code == ErrorCode::machine_door || code == ErrorCode::machine_temperature;
}

bool of_disk(ErrorCode code) {
    return code == ErrorCode::journal_full || code == ErrorCode::journal_slow;
}

std::string seconds_text(double seconds) {
    return core::fixed(seconds, 0) + " s";
}

}  // namespace

bool ScanJob::may_pass(const core::Error& error) const {
    const bool waits = request_.part.scan.wait_s > 0.0 && step(state_, SessionInput::held).accepted;
    // What a person has taken by hand and the disk did not get cannot be fetched again.
    const bool can_go_on = owner_ && journal_ && capabilities_.moves;
    return waits && can_go_on && !stop_requested_ && !error_ && (of_machine(error.code) || of_disk(error.code));
}

ScanJob::Step ScanJob::hold() {
    core::Error cause = std::move(*held_by_);
    held_by_.reset();
    const auto stands = co_await come_to_rest();
    if (!stands) co_return tl::unexpected(stands.error());
    if (stands->in_motion) {
        co_return core::fail(ErrorCode::machine_fault, "the machine still moves after the stop",
                             core::Motion::may_be_moving);
    }
    announce_hold(cause);
    boost::asio::steady_timer pause(co_await boost::asio::this_coro::executor);
    while (true) {
        const auto began = std::chrono::steady_clock::now();
        ask_for_room(cause);
        for (int look = 0; look < looks_a_beat; ++look) {
            if (stop_requested_) co_return core::Status{};
            pause.expires_after(between_looks);
            co_await pause.async_wait(boost::asio::use_awaitable);
        }
        const auto passed = co_await has_passed(cause);
        waited_s_ += core::seconds(std::chrono::steady_clock::now() - began);
        if (!passed) co_return tl::unexpected(passed.error());
        if (*passed) break;
        if (waited_s_ >= request_.part.scan.wait_s) {
            co_return tl::unexpected(std::move(cause).with_context("waited " + seconds_text(waited_s_) + " for it"));
        }
        progress("waiting " + seconds_text(waited_s_) + " of " + seconds_text(request_.part.scan.wait_s) + ": " +
                 cause.text());
    }
    notice("it has passed: going on");
    going_on_ = true;
    co_return core::Status{};
}

void ScanJob::announce_hold(const core::Error& cause) {
    // The whole time again only for a run that has got on since it waited last.
    const std::uint64_t reached = journal_ ? journal_->durable_sequence() : held_after_;
    if (reached > held_after_) waited_s_ = 0.0;
    held_after_ = reached;
    const double left_s = std::max(0.0, request_.part.scan.wait_s - waited_s_);
    if (journal_) keep_events();
    events_.emit(EventKind::hold, 0.0,
                 JsonFields()
                     .add("code", core::to_string(cause.code))
                     .add("message", cause.text())
                     .add("section", section_)
                     .add("wait_s", left_s, 1)
                     .text());
    notice("waiting at rest, up to " + seconds_text(left_s) + ": " + cause.text() +
           "; goes on by itself when it has passed, Ctrl-C ends it");
}

/// So that the answer is there when the next beat is over; a disk that does not answer holds nothing up.
void ScanJob::ask_for_room(const core::Error& cause) {
    if (cause.code != ErrorCode::journal_full) return;
    disk_room_.ask([ask = request_.disk_has_room, file = request_.run_file] { return ask(file, room_wanted); });
}

boost::asio::awaitable<core::Result<bool>> ScanJob::has_passed(core::Error& cause) {
    // Asked for the disk as well: the link stays open, and an emergency stop is noticed.
    const auto now = co_await machine_.state();
    if (!now) co_return tl::unexpected(now.error());
    if (of_machine(cause.code)) {
        auto cleared = co_await machine_.clear_fault();
        if (cleared) co_return true;
        if (!of_machine(cleared.error().code)) co_return tl::unexpected(std::move(cleared.error()));
        if (cleared.error().code != cause.code) cause = std::move(cleared.error());
        co_return false;
    }
    if (now->state == drivers::MachineState::emergency)
        co_return core::fail(ErrorCode::machine_emergency, "emergency stop", core::Motion::stopped);
    if (cause.code == ErrorCode::journal_slow) {
        const auto durable = journal_->hasten();
        co_return !durable || *durable;  // a disk that has failed will say so again
    }
    if (!disk_room_.answer().value_or(false)) co_return false;
    co_return co_await replace_journal();
}

/// A journal that the disk has failed stays failed; another one takes up the file, which ends where the disk had all.
boost::asio::awaitable<core::Result<bool>> ScanJob::replace_journal() {
    intake_.reset();
    // The disk may hold up its end as well.
    auto close = [failed = std::exchange(journal_, nullptr)]() mutable {
        failed.reset();
        return core::Status{};
    };
    (void)co_await workers_.run(std::move(close));
    auto status = co_await reopen_journal();
    if (status) {
        keep_events();
        co_return true;
    }
    journal_.reset();
    const bool again = of_disk(status.error().code) || status.error().code == ErrorCode::journal_io;
    if (!again) co_return tl::unexpected(std::move(status.error()));
    co_return false;
}

}  // namespace cmm::acquisition
