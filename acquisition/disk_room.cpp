// SPDX-License-Identifier: Apache-2.0
#include "acquisition/disk_room.hpp"

#include <fcntl.h>
#include <unistd.h>

namespace cmm::acquisition {

bool disk_has_room(const std::string& beside, std::int64_t bytes) {
    const std::string probe = beside + ".room";
    const int descriptor = ::open(probe.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (descriptor < 0) return false;
    const bool room = ::posix_fallocate(descriptor, 0, bytes) == 0;
    ::close(descriptor);
    ::unlink(probe.c_str());
    return room;
}

}  // namespace cmm::acquisition
