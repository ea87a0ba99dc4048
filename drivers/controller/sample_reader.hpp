// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include "core/error.hpp"
#include "core/sample.hpp"
#include "drivers/controller/port.hpp"
#include "drivers/machine.hpp"

namespace cmm::drivers::controller {

/// Turns sample blocks into the samples of a run: each once, in order, numbered from 1, or an error. Knows which sample
/// to ask for next and what may be acknowledged. Not thread-safe; no I/O.
class SampleReader {
  public:
    /// Begins (or takes up) a run. `acknowledged` is what the controller has given up already, in its own numbers.
    void begin(const RunOrigin& origin, std::uint32_t acknowledged);
    const RunOrigin& origin() const noexcept { return origin_; }

    /// Whether a block was asked for by the number that is due, or further ahead, before it was known what comes
    /// before.
    enum class Asked : std::uint8_t { due, ahead };

    /// The samples of a checked block that are new, as part of `samples`, numbered within the run. A block asked for
    /// ahead that does not follow on is dropped: what is missing is asked for again. Errors: protocol_invalid (a gap,
    /// numbers that go back), machine_overflow (a gap after the controller's FIFO ran full).
    core::Result<std::span<const core::Sample>> take(const FifoBlock& block, std::span<core::Sample> samples,
                                                     std::int64_t host_time_ns, Asked asked = Asked::due);
    /// Samples seen so far may be acknowledged up to this number of the run.
    void durable(std::uint64_t run_sequence);

    std::uint32_t next_wanted() const noexcept { return next_; }     ///< controller's number
    std::uint32_t acknowledge() const noexcept { return durable_; }  ///< controller's number
    std::uint64_t last_delivered() const noexcept { return run_sequence(next_ - 1); }
    std::uint64_t duplicates() const noexcept { return duplicates_; }
    /// The number within the run of a controller's number; 0 when it is older than the run.
    std::uint64_t run_sequence(std::uint32_t controller_sequence) const noexcept;

  private:
    RunOrigin origin_;
    std::uint32_t next_ = 1;
    std::uint32_t durable_ = 0;
    std::uint64_t duplicates_ = 0;
};

}  // namespace cmm::drivers::controller
