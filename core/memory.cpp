// SPDX-License-Identifier: Apache-2.0
#include "core/memory.hpp"

#include <cstdlib>  // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace cmm::core {

bool keep_freed_memory() noexcept {
#ifdef __GLIBC__
    constexpr int megabyte = 1 << 20;
    const bool kept = ::mallopt(M_TRIM_THRESHOLD, 64 * megabyte) != 0;
    const bool in_heap = ::mallopt(M_MMAP_THRESHOLD, 32 * megabyte) != 0;  // the largest that glibc takes
    const bool ahead = ::mallopt(M_TOP_PAD, megabyte) != 0;
    return kept && in_heap && ahead;
#else
    return false;
#endif
}

}  // namespace cmm::core
