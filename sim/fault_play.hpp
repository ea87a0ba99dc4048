// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.hpp"
#include "core/rng.hpp"
#include "sim/controller.hpp"
#include "sim/fault_plan.hpp"

namespace cmm::sim {

/// A fault plan being carried out on one simulated machine and its wires. `clock` and `controller` outlive it. One
/// thread, that of the controller.
class FaultPlay {
  public:
    /// Told a line of text for each fault that strikes, and when the machine has come to rest after it.
    using Tell = std::function<void(const std::string&)>;
    FaultPlay(const FaultPlan& plan, std::uint64_t seed, Controller& controller, const core::Clock& clock, Tell tell);

    void count_sample() { ++samples_; }
    /// Breaks what is due on the machine and mends what is over; once a round.
    void step();

    /// The wire fault that the reply to the next request meets; nullptr: none. Counts the request.
    const Fault* next_reply();
    /// The fault that arriving bytes meet; nullptr: none.
    const Fault* next_arrival();
    /// Nothing is heard or said: the controller hangs, or the cable is out.
    bool silent() const { return clock_.now() < silent_until_; }
    /// Connections made before this number last changed are dead: the controller was restarted.
    unsigned generation() const { return generation_; }
    /// Lets bytes get lost or spoilt at the rates of the present.
    void spoil(std::vector<std::uint8_t>& bytes);
    core::Duration now() const { return clock_.now(); }
    core::Rng& rng() { return rng_; }

  private:
    struct Entry {
        Fault fault;
        double at = 0.0;
        bool armed = true;
        int left = 0;            // messages
        core::Duration ends{0};  // of what lasts
        bool under_way = false;
    };
    double count(FaultTime::Count what) const;
    void draw(Entry& entry, double base);
    bool due(const Entry& entry) const;
    bool fits_motion(FaultKind kind) const;
    void strike(Entry& entry);
    void break_machine(const Fault& fault);
    void mend(Entry& entry);
    const Fault* next_message(bool arriving);
    bool moving() const { return (controller_.flags() & 8U) != 0; }
    void watch_rest();

    std::vector<Entry> entries_;
    core::Rng rng_;
    Controller& controller_;
    const core::Clock& clock_;
    Tell tell_;
    std::uint64_t samples_ = 0, requests_ = 0;
    core::Duration first_request_{0}, silent_until_{0};
    unsigned generation_ = 0;
    // A motion that a fault met, until it ends.
    bool watching_ = false;
    core::Duration struck_{0};
    double struck_machine_s_ = 0.0;
};

}  // namespace cmm::sim
