// SPDX-License-Identifier: Apache-2.0
// Preloaded into a program: every fsync and fdatasync takes SLOW_DISK_MS longer, as on a disk that is busy or failing.
#include <dlfcn.h>

#include <chrono>
#include <cstdlib>
#include <thread>

namespace {

int synchronised(const char* name, int fd) {
    using Sync = int (*)(int);
    const auto real = reinterpret_cast<Sync>(::dlsym(RTLD_NEXT, name));
    const char* ms = std::getenv("SLOW_DISK_MS");
    std::this_thread::sleep_for(std::chrono::milliseconds(ms == nullptr ? 0 : std::atoi(ms)));
    return real(fd);
}

}  // namespace

extern "C" int fsync(int fd) {
    return synchronised("fsync", fd);
}
extern "C" int fdatasync(int fd) {
    return synchronised("fdatasync", fd);
}
