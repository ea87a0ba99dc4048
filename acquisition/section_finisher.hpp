// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "acquisition/event_payload.hpp"
#include "acquisition/events.hpp"
#include "acquisition/live_section.hpp"
#include "acquisition/part_judge.hpp"
#include "acquisition/section_result.hpp"
#include "acquisition/workers.hpp"
#include "core/clock.hpp"

namespace cmm::acquisition {

/// p50, p99 and max of a set of times, milliseconds.
struct LatencySummary {
    std::size_t count = 0;
    double p50_ms = 0.0, p99_ms = 0.0, max_ms = 0.0;
};
LatencySummary summarise(std::vector<double> times_ms);

/// From a section's last sample (host receive time) to its SectionFinal, and to the decision about it.
struct SectionLatency {
    LatencySummary closed, decided;
};

/// Fits and judges completed sections on the workers, one step at a time, while the machine measures on, and announces
/// them (SectionFinal and PointRejected when the contour is there, CharacteristicUpdated and GateDecision when it is
/// judged); and again what the sections after them change (SectionRevised, CharacteristicUpdated, GateDecision).
/// `submit` never waits for a fit; any thread.
class SectionFinisher {
  public:
    SectionFinisher(EventHub& events, const core::Clock& clock, Workers& workers);
    /// Waits for the fits under way.
    ~SectionFinisher();
    SectionFinisher(const SectionFinisher&) = delete;
    SectionFinisher& operator=(const SectionFinisher&) = delete;

    void submit(std::unique_ptr<LiveSection> section);
    /// Judges `points` as the section that will be submitted in `left_ms`, and forgets it: code and data are in the
    /// caches then, and its thread stays awake until that is there (or others have work): the section itself takes a
    /// third less. Not where somebody might have to wait for it: a judgement under way, or one that took more than a
    /// fifth of the time left.
    void rehearse(const SectionSetup& setup, std::vector<RecordedPoint> points, double left_ms);
    /// Whether one of the finished sections is rejected for certain: then the part is, whatever comes.
    bool rejected() const;
    /// No more sections come for now: all are compensated by the whole surface, and aligned. A section that is
    /// submitted again afterwards, with more points, takes the place of the first, and asks for it once more. `whole`:
    /// as of PartJudge::complete.
    void complete(bool whole = true);
    /// As they are judged by now, by index; while idle.
    std::vector<SectionResult> results() const { return judge_.results(); }
    /// Whether all that was asked for is finished.
    bool idle() const;
    /// Waits until all submitted sections are finished and hands them over, by index.
    std::vector<SectionResult> take_all();
    /// Sections restored from a run file have none.
    SectionLatency latency() const;

  private:
    /// What comes next: of the last section the surface that grows by it, then its own lean; or another section.
    enum class Step : std::uint8_t { grow, foretell, finish };

    std::optional<TimeTaken> since(std::optional<core::Duration> received, std::vector<double>& latencies_ms);
    void took_since(core::Duration begun);
    void begin();
    void step();
    void go_on();
    void finish_next(std::unique_lock<std::mutex>& lock);
    void announce_closed(const SectionResult& section, std::optional<core::Duration> received);
    void announce_revised(const std::vector<const SectionResult*>& revised);
    void announce_rejected(const SectionResult& result);
    void announce_decisions(const SectionResult& result, std::optional<core::Duration> received);

    EventHub& events_;
    const core::Clock& clock_;
    Workers& workers_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    // Of the worker, while busy.
    PartJudge judge_;
    double t_machine_s_ = 0.0;          // of the last section
    core::Duration processor_begun_{};  // the thread's time when it began with that
    Step next_ = Step::finish;
    std::map<std::size_t, std::set<std::uint64_t>> told_rejected_;  // points by section
    std::deque<std::unique_ptr<LiveSection>> waiting_;
    bool complete_ = false;      // asked for
    bool new_sections_ = false;  // since it was asked for
    bool whole_ = true;
    double judgement_ms_ = 0.0;  // what the last section took by itself
    std::vector<double> closed_ms_, decided_ms_;
    bool rejected_ = false;
    bool busy_ = false;  // a worker has been asked to go through those waiting, and has not ended
};

}  // namespace cmm::acquisition
