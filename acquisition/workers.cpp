// SPDX-License-Identifier: Apache-2.0
#include "acquisition/workers.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

namespace cmm::acquisition {

Workers::Workers() : Workers(std::max(2U, std::thread::hardware_concurrency()) - 1) {}

void Workers::stay_awake(std::chrono::nanoseconds at_most) const {
    const auto until = std::chrono::steady_clock::now() + at_most;
    while (asked_ == 0 && std::chrono::steady_clock::now() < until)
        std::this_thread::yield();
}

}  // namespace cmm::acquisition
