// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace cmm::core {

using Duration = std::chrono::nanoseconds;

/// Where time comes from. Passed in by reference, outlives its users, may be read from any thread.
/// `now` is monotonic since an arbitrary origin; `utc_ns` is wall time for records only, never for intervals.
class Clock {
  public:
    virtual ~Clock() = default;
    virtual Duration now() const noexcept = 0;
    virtual std::int64_t utc_ns() const noexcept = 0;

  protected:
    Clock() = default;
    Clock(const Clock&) = default;
    Clock& operator=(const Clock&) = default;
};

/// The machine's own steady and system clocks.
class SystemClock final : public Clock {
  public:
    Duration now() const noexcept override;
    std::int64_t utc_ns() const noexcept override;
};

/// A clock that a test turns by hand.
class ManualClock final : public Clock {
  public:
    explicit ManualClock(std::int64_t utc_origin_ns = 0) noexcept : utc_origin_ns_(utc_origin_ns) {}
    Duration now() const noexcept override;
    std::int64_t utc_ns() const noexcept override;
    void advance(Duration step) noexcept;

  private:
    std::atomic<std::int64_t> now_ns_{0};
    std::int64_t utc_origin_ns_;
};

constexpr double seconds(Duration d) noexcept {
    return std::chrono::duration<double>(d).count();
}

/// Whole nanoseconds, the rest cut off.
constexpr Duration from_ms(double ms) noexcept {
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(ms));
}

}  // namespace cmm::core
