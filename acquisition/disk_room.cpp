// SPDX-License-Identifier: Apache-2.0
#include "acquisition/disk_room.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <system_error>
#include <thread>
#include <utility>

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

struct DiskQuestion::Open {
    std::atomic<bool> answered{false};
    bool yes = false;  // of the thread until then
};

void DiskQuestion::ask(std::function<bool()> question) {
    if (open_) return;
    const auto open = std::make_shared<Open>();
    auto work = [open, question = std::move(question)] {
        open->yes = question();
        open->answered.store(true, std::memory_order_release);
    };
    try {
        std::thread(std::move(work)).detach();
        open_ = open;
    } catch (const std::system_error&) {
        // No thread to be had at the moment: it will be asked again.
    }
}

std::optional<bool> DiskQuestion::answer() {
    if (!open_ || !open_->answered.load(std::memory_order_acquire)) return std::nullopt;
    return std::exchange(open_, nullptr)->yes;
}

}  // namespace cmm::acquisition
