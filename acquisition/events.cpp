// SPDX-License-Identifier: Apache-2.0
#include "acquisition/events.hpp"

#include <algorithm>

#include <utility>

#include "acquisition/json_text.hpp"

namespace cmm::acquisition {

std::string_view to_string(EventKind kind) noexcept {
    switch (kind) {
        case EventKind::run_started:
            return "RunStarted";
        case EventKind::path_started:
            return "PathStarted";
        case EventKind::sample_batch:
            return "SampleBatch";
        case EventKind::point_rejected:
            return "PointRejected";
        case EventKind::section_updated:
            return "SectionUpdated";
        case EventKind::section_final:
            return "SectionFinal";
        case EventKind::section_revised:
            return "SectionRevised";
        case EventKind::characteristic_updated:
            return "CharacteristicUpdated";
        case EventKind::gate_decision:
            return "GateDecision";
        case EventKind::line_garbled:
            return "LineGarbled";
        case EventKind::hold:
            return "Hold";
        case EventKind::resume:
            return "Resume";
        case EventKind::machine_fault:
            return "MachineFault";
        case EventKind::link_stats:
            return "LinkStats";
        case EventKind::run_stopped:
            return "RunStopped";
        case EventKind::points_chosen:
            return "PointsChosen";
        case EventKind::measure_again:
            return "MeasureAgain";
        case EventKind::part_aligned:
            return "PartAligned";
        case EventKind::point_restored:
            return "PointRestored";
    }
    return "Unknown";
}

void EventHub::listen(Listener listener) {
    const std::lock_guard guard(mutex_);
    listeners_.push_back(std::move(listener));
}

void EventHub::emit(EventKind kind, double t_machine_s, std::string payload) {
    // Numbering and delivery are one step, so that no listener sees the events out of order.
    const std::lock_guard guard(mutex_);
    const Event event{++seq_, kind, t_machine_s, core::seconds(clock_.now() - origin_), std::move(payload)};
    for (const auto& listener : listeners_)
        listener(event);
}

void EventHub::continue_after(std::uint64_t last_seq) {
    const std::lock_guard lock(mutex_);
    seq_ = std::max(seq_, last_seq);
}

std::uint64_t EventHub::last_seq() const {
    const std::lock_guard guard(mutex_);
    return seq_;
}

std::string to_ndjson(const Event& event) {
    constexpr int time_digits = 6;
    std::string line = "{" + JsonFields()
                                 .add("seq", event.seq)
                                 .add("event", to_string(event.kind))
                                 .add("t_machine_s", event.t_machine_s, time_digits)
                                 .add("t_host_s", event.t_host_s, time_digits)
                                 .text();
    if (!event.payload.empty()) line += "," + event.payload;
    return line + "}";
}

}  // namespace cmm::acquisition
