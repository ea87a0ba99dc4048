// SPDX-License-Identifier: Apache-2.0
#include "acquisition/workers.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <thread>
#include <utility>

namespace cmm::acquisition {

void Workers::step_back() noexcept {
    constexpr int niceness = 5;
    thread_local bool done = false;
    if (!std::exchange(done, true)) ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), niceness);
}

Workers::Workers() : Workers(std::max(2U, std::thread::hardware_concurrency()) - 1) {}

}  // namespace cmm::acquisition
