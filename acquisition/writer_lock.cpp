// SPDX-License-Identifier: Apache-2.0
#include "acquisition/writer_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace cmm::acquisition {

core::Result<WriterLock> WriterLock::take(const std::string& file) {
    WriterLock lock(::open(file.c_str(), O_RDWR | O_CLOEXEC));
    if (lock.descriptor_ < 0) {
        return core::fail(core::ErrorCode::journal_io, file + ": cannot open for writing: " + std::strerror(errno));
    }
    // flock, not fcntl: SQLite holds fcntl locks of its own on this file.
    if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0) {
        return core::fail(core::ErrorCode::journal_io, file + ": another run is writing it");
    }
    return lock;
}

WriterLock::WriterLock(WriterLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

WriterLock::~WriterLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace cmm::acquisition
