// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"

namespace cmm::acquisition {

enum class EventKind : std::uint8_t {
    run_started,
    path_started,
    sample_batch,
    point_rejected,
    section_updated,
    section_final,
    section_revised,
    characteristic_updated,
    gate_decision,
    line_garbled,
    hold,
    resume,
    machine_fault,
    link_stats,
    run_stopped,
    points_chosen,
    measure_again,
    part_aligned,
    point_restored,
};
/// "RunStarted", "PathStarted", ... as in the NDJSON stream.
std::string_view to_string(EventKind kind) noexcept;

/// One event of a run. `payload` is a JSON object body without braces, e.g. `"section":3,"points":120`.
struct Event {
    std::uint64_t seq = 0;
    EventKind kind = EventKind::run_started;
    double t_machine_s = 0.0;
    double t_host_s = 0.0;  ///< since the run started
    std::string payload;
};

/// Numbers events and hands them to the listeners, in order. Thread-safe; listeners run on the emitter's thread, one
/// event at a time: they are quick and do not emit. The clock outlives the hub. A resumed run counts on from
/// `last_seq`.
class EventHub {
  public:
    explicit EventHub(const core::Clock& clock) : clock_(clock), origin_(clock.now()) {}
    /// A resumed run counts on from the events that its run file holds.
    void continue_after(std::uint64_t last_seq);
    using Listener = std::function<void(const Event&)>;
    void listen(Listener listener);
    void emit(EventKind kind, double t_machine_s, std::string payload);
    std::uint64_t last_seq() const;
    /// Milliseconds since an instant of the clock.
    double age_ms(core::Duration since) const { return core::seconds(clock_.now() - since) * 1e3; }

  private:
    const core::Clock& clock_;
    core::Duration origin_;
    mutable std::mutex mutex_;
    std::uint64_t seq_ = 0;
    std::vector<Listener> listeners_;
};

/// The event as one line of NDJSON with "seq", "event", "t_machine_s", "t_host_s" and the payload.
std::string to_ndjson(const Event& event);

}  // namespace cmm::acquisition
