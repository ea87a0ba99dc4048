// SPDX-License-Identifier: Apache-2.0
#include "core/memory.hpp"

#include <cstdlib>  // defines __GLIBC__

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace cmm::core {

void keep_freed_memory() noexcept {
#ifdef __GLIBC__
    constexpr int megabyte = 1 << 20;
    ::mallopt(M_TRIM_THRESHOLD, 64 * megabyte);
    ::mallopt(M_MMAP_THRESHOLD, 32 * megabyte);  // the largest that glibc takes
    ::mallopt(M_TOP_PAD, megabyte);
#endif
}

}  // namespace cmm::core
