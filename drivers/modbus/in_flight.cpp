// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/in_flight.hpp"

#include <algorithm>

namespace cmm::drivers::modbus {
namespace {

constexpr int most_half_answered = 2;
constexpr int most_broken_in_row = 2;
constexpr double weight_of_newest = 0.3;

}  // namespace

std::size_t InFlight::allowed() const noexcept {
    if (half_answered_ >= most_half_answered || broken_in_row_ >= most_broken_in_row) return 1;
    if (most_ <= fewest || service_ms_ * static_cast<double>(most_) <= longest_queue_ms) return most_;
    return std::clamp(static_cast<std::size_t>(longest_queue_ms / service_ms_), fewest, most_);
}

bool InFlight::judge(std::size_t sent, std::size_t answered, bool link_stands, double service_ms) noexcept {
    const bool before = allowed() == 1;
    if (answered == sent) {
        broken_in_row_ = 0;
        service_ms_ += weight_of_newest * (service_ms - service_ms_);
    } else if (answered > 0 && link_stands) {
        ++half_answered_;
    } else {
        ++broken_in_row_;
    }
    return !before && allowed() == 1;
}

}  // namespace cmm::drivers::modbus
