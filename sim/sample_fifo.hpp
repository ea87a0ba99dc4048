// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>

namespace cmm::sim {

/// Quality bits of a sample on the wire.
namespace quality {
inline constexpr std::uint16_t no_contact = 1;
inline constexpr std::uint16_t touch = 4;
}  // namespace quality

struct FifoSample {
    std::uint32_t seq = 0;  ///< 1, 2, 3, ... since the controller was switched on
    std::uint16_t path = 0;
    std::int64_t time_us = 0;              ///< machine time
    std::array<std::int32_t, 3> counts{};  ///< ball centre
    std::uint16_t quality = 0;
};

/// The samples that the host has not acknowledged yet. Sequences have no gaps. One thread.
class SampleFifo {
  public:
    explicit SampleFifo(std::size_t depth) : depth_(depth) {}

    bool full() const { return samples_.size() >= depth_; }
    std::size_t level() const { return samples_.size(); }
    std::uint32_t newest() const { return newest_; }
    std::uint32_t acknowledged() const { return newest_ - static_cast<std::uint32_t>(samples_.size()); }
    /// Gives the sample its sequence; the caller has asked `full`.
    std::uint32_t push(FifoSample sample);
    /// Frees everything up to `seq`; false if there is no such sample yet.
    bool acknowledge(std::uint32_t seq);
    bool holds(std::uint32_t seq) const { return seq > acknowledged() && seq <= newest_; }
    const FifoSample& at(std::uint32_t seq) const { return samples_[seq - acknowledged() - 1]; }

  private:
    std::size_t depth_;
    std::deque<FifoSample> samples_;
    std::uint32_t newest_ = 0;
};

}  // namespace cmm::sim
