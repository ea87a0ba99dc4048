// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace cmm::drivers::modbus {

/// How many requests may be under way at once: what the user allows; fewer where the controller is slow, because a stop
/// is served behind what was sent before it; one where the controller does not answer what comes together
/// (docs/adr/0008-requests-in-flight.md). A plain value, no I/O.
class InFlight {
  public:
    static constexpr double longest_queue_ms = 20.0;  ///< of a stop's way, 50 ms in all
    static constexpr std::size_t fewest = 2;          ///< of several: with fewer nothing is learnt any more

    explicit InFlight(std::size_t most) : most_(most) {}
    std::size_t most() const noexcept { return most_; }
    std::size_t allowed() const noexcept;

    /// After each batch of two or more: how many were sent and how many of them answered, whether the link still
    /// stands, and how long the controller took for one (0: not known). True: from now on it is one at a time.
    bool judge(std::size_t sent, std::size_t answered, bool link_stands, double service_ms) noexcept;
    /// A controller that has just been connected to may be another one.
    void begin_anew() noexcept { *this = InFlight(most_); }

  private:
    std::size_t most_;
    double service_ms_ = 0.0;  // smoothed
    int half_answered_ = 0;    // batches, since the beginning
    int broken_in_row_ = 0;    // batches that cost the link, or that nobody answered
};

}  // namespace cmm::drivers::modbus
