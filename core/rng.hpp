// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace cmm::core {

/// Seeded random numbers that are the same on every machine and compiler (the std distributions are not).
/// Generator: splitmix64 (Steele, Lea, Flood 2014). Not for secrets. One owner, no locking.
class Rng {
  public:
    explicit Rng(std::uint64_t seed) noexcept : state_(seed) {}

    /// An independent stream for a purpose and an index: the k-th draw of it does not depend on what other streams
    /// drew.
    static Rng keyed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) noexcept;

    std::uint64_t next() noexcept;
    /// Uniform in [0, 1).
    double uniform() noexcept;
    /// Uniform in [low, high).
    double uniform(double low, double high) noexcept { return low + (high - low) * uniform(); }
    /// Uniform integer in [0, bound); bound > 0.
    std::uint64_t below(std::uint64_t bound) noexcept;
    /// Standard normal (Box and Muller 1958, one value a call).
    double normal() noexcept;

  private:
    std::uint64_t state_;
};

}  // namespace cmm::core
