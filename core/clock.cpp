// SPDX-License-Identifier: Apache-2.0
#include "core/clock.hpp"

namespace cmm::core {

Duration SystemClock::now() const noexcept {
    return std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch());
}

std::int64_t SystemClock::utc_ns() const noexcept {
    return std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()).count();
}

Duration ManualClock::now() const noexcept {
    return Duration(now_ns_.load());
}
std::int64_t ManualClock::utc_ns() const noexcept {
    return utc_origin_ns_ + now_ns_.load();
}
void ManualClock::advance(Duration step) noexcept {
    now_ns_ += step.count();
}

}  // namespace cmm::core
