// SPDX-License-Identifier: Apache-2.0
#include "core/processor_time.hpp"

#include <ctime>

namespace cmm::core {

Duration thread_processor_time() noexcept {
    timespec used{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
    return std::chrono::seconds(used.tv_sec) + Duration(used.tv_nsec);
}

}  // namespace cmm::core
