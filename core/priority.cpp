// SPDX-License-Identifier: Apache-2.0
#include "core/priority.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace cmm::core {

void stand_back(int niceness) noexcept {
    thread_local bool done = false;
    // A refusal costs order among threads, nothing else.
    if (!std::exchange(done, true)) ::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), niceness);
}

}  // namespace cmm::core
