// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_finisher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acquisition/event_payload.hpp"
#include "core/processor_time.hpp"

namespace cmm::acquisition {
namespace {

constexpr double rehearsals_within = 5.0;
constexpr double late_ms = 20.0;  // the last point, by what its section was going to take

}  // namespace

LatencySummary summarise(std::vector<double> times_ms) {
    if (times_ms.empty()) return {};
    std::sort(times_ms.begin(), times_ms.end());
    // Nearest rank: the smallest time that the share of all times does not exceed.
    const auto rank = [&](double share) {
        const auto n = static_cast<double>(times_ms.size());
        return times_ms[static_cast<std::size_t>(std::max(0.0, std::ceil(share * n) - 1.0))];
    };
    return {times_ms.size(), rank(0.50), rank(0.99), times_ms.back()};
}

SectionFinisher::SectionFinisher(EventHub& events, const core::Clock& clock, Workers& workers)
    : events_(events), clock_(clock), workers_(workers) {}

SectionFinisher::~SectionFinisher() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
}

void SectionFinisher::submit(std::unique_ptr<LiveSection> section) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(section));
    new_sections_ = true;
    begin();
}

void SectionFinisher::complete(bool whole) {
    const std::lock_guard lock(mutex_);
    if (!std::exchange(new_sections_, false)) return;
    whole_ = whole;
    complete_ = true;
    begin();
}

/// Under the mutex.
void SectionFinisher::begin() {
    if (!std::exchange(busy_, true)) workers_.post([this] { step(); });
}

void SectionFinisher::rehearse(const SectionSetup& setup, std::vector<RecordedPoint> points, double left_ms) {
    const std::lock_guard lock(mutex_);
    if (busy_ || judgement_ms_ * rehearsals_within > left_ms) return;
    busy_ = true;
    workers_.post([this, &setup, left_ms, points = std::move(points), judge = judge_.alone()]() mutable {
        const auto begun = clock_.now();
        (void)judge.finish(setup, std::move(points));
        took_since(begun);
        const Workers& workers = workers_;
        go_on();  // whoever waits for that may destroy this object
        workers.stay_awake(core::from_ms(left_ms + late_ms));
    });
}

bool SectionFinisher::rejected() const {
    const std::lock_guard lock(mutex_);
    return rejected_;
}

bool SectionFinisher::idle() const {
    const std::lock_guard lock(mutex_);
    return !busy_;
}

std::vector<SectionResult> SectionFinisher::take_all() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !busy_; });
    return judge_.take();
}

SectionLatency SectionFinisher::latency() const {
    const std::lock_guard lock(mutex_);
    return {summarise(closed_ms_), summarise(decided_ms_)};
}

void SectionFinisher::took_since(core::Duration begun) {
    const std::lock_guard lock(mutex_);
    judgement_ms_ = core::seconds(clock_.now() - begun) * 1e3;
}

/// One step, so that the sections of other parts do not wait for all that is left of this one.
void SectionFinisher::step() {
    if (next_ == Step::grow) {
        announce_revised(judge_.grow());
        next_ = Step::foretell;
    } else if (next_ == Step::foretell) {
        if (const auto* newest = judge_.foretell()) announce_revised({newest});
        next_ = Step::finish;
    } else {
        std::unique_lock lock(mutex_);
        if (!waiting_.empty()) {
            finish_next(lock);
        } else if (std::exchange(complete_, false)) {
            const bool whole = whole_;
            lock.unlock();
            announce_revised(judge_.begin_completion(whole));
        } else {
            lock.unlock();
            if (const auto* section = judge_.complete_next()) announce_revised({section});
        }
    }
    go_on();
}

/// Behind what others have asked the workers for.
void SectionFinisher::go_on() {
    const std::lock_guard lock(mutex_);
    if (next_ != Step::finish || !waiting_.empty() || complete_ || judge_.completing()) {
        workers_.post([this] { step(); });
    } else {
        busy_ = false;
        changed_.notify_all();  // under the mutex: who waits may destroy this object
    }
}

void SectionFinisher::finish_next(std::unique_lock<std::mutex>& lock) {
    const auto section = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    const SectionSetup& setup = section->setup();
    const bool again = judge_.has(setup.index);
    const auto received = section->last_sample_host_time();
    t_machine_s_ = section->last_machine_time_s();
    const auto begun = clock_.now();
    processor_begun_ = core::thread_processor_time();
    auto closed = judge_.close(setup, section->points());
    const bool stays = !PartJudge::changes_when_judged(closed);
    if (stays) announce_closed(closed, received);
    const auto& result = judge_.take_over(setup, judge_laid(std::move(closed), setup));
    took_since(begun);
    if (!stays) announce_closed(result, received);
    announce_decisions(result, received);
    next_ = again ? Step::finish : Step::grow;  // the surface through all sections is laid anew
    lock.lock();
}

/// One more of `latencies_ms`, where there is a last sample.
std::optional<TimeTaken> SectionFinisher::since(std::optional<core::Duration> received,
                                                std::vector<double>& latencies_ms) {
    if (!received) return std::nullopt;
    const double ms = core::seconds(clock_.now() - *received) * 1e3;
    const double processor_ms = core::seconds(core::thread_processor_time() - processor_begun_) * 1e3;
    const std::lock_guard lock(mutex_);
    latencies_ms.push_back(ms);
    return TimeTaken{ms, processor_ms};
}

void SectionFinisher::announce_closed(const SectionResult& section, std::optional<core::Duration> received) {
    events_.emit(EventKind::section_final, t_machine_s_, final_payload(section, since(received, closed_ms_)));
    told_rejected_[section.index].clear();
    announce_rejected(section);
}

/// The points that were not yet announced: some are found bad when the other sections are there, and some good.
void SectionFinisher::announce_rejected(const SectionResult& result) {
    auto& told = told_rejected_[result.index];
    for (const auto& point : result.points) {
        if (point.verdict.reason != fitting::RejectReason::none) {
            if (told.insert(point.sequence).second)
                events_.emit(EventKind::point_rejected, t_machine_s_, rejected_payload(result.index, point));
        } else if (told.erase(point.sequence) > 0) {
            events_.emit(EventKind::point_restored, t_machine_s_, restored_payload(result.index, point));
        }
    }
}

void SectionFinisher::announce_revised(const std::vector<const SectionResult*>& revised) {
    for (const auto* result : revised) {
        events_.emit(EventKind::section_revised, t_machine_s_, revised_payload(*result));
        announce_rejected(*result);
        announce_decisions(*result, std::nullopt);
    }
}

/// A section that hangs on what its neighbours will say is not rejected for certain yet.
void SectionFinisher::announce_decisions(const SectionResult& result, std::optional<core::Duration> received) {
    for (const auto& characteristic : result.characteristics) {
        events_.emit(EventKind::characteristic_updated, t_machine_s_,
                     characteristic_payload(result.index, characteristic));
    }
    const bool certain = judge_.rejects_for_certain(result.index);
    if (certain) {
        const std::lock_guard lock(mutex_);
        rejected_ = true;
    }
    events_.emit(EventKind::gate_decision, t_machine_s_,
                 decision_payload(result.index, result.decision(), certain, since(received, decided_ms_)));
}

}  // namespace cmm::acquisition
