// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/clock.hpp"
#include "core/sample.hpp"

namespace cmm::acquisition {

/// When recorded samples are due: the first one asked about at once, every other one as long after it by the host's
/// clock as it was by the machine's, divided by the speed. One owner; the clock outlives it.
class ReplayPace {
  public:
    /// Speed 0: everything is due at once.
    ReplayPace(double speed, const core::Clock& clock) : speed_(speed), clock_(clock) {}
    bool at_once() const { return speed_ <= 0.0; }
    /// How many of the next samples are due now.
    std::size_t due(std::span<const core::Sample> samples);

  private:
    struct Start {
        std::int64_t machine_us;
        core::Duration host;
    };
    double speed_;
    const core::Clock& clock_;
    std::optional<Start> start_;
};

}  // namespace cmm::acquisition
