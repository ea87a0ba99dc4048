// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <system_error>

namespace cmm::drivers {

/// Wakes a thread that waits by poll(). signal() may be called from any thread. Throws std::system_error when the
/// system has no descriptors left.
class EventFd {
  public:
    EventFd() : fd_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
        if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
    }
    ~EventFd() { ::close(fd_); }
    EventFd(const EventFd&) = delete;
    EventFd& operator=(const EventFd&) = delete;
    int fd() const noexcept { return fd_; }
    void signal() const noexcept {
        const std::uint64_t one = 1;
        // Fails only when the counter is full: then it is signalled already.
        [[maybe_unused]] const auto written = ::write(fd_, &one, sizeof one);
    }
    void clear() const noexcept {
        std::uint64_t count = 0;
        [[maybe_unused]] const auto taken = ::read(fd_, &count, sizeof count);
    }

  private:
    int fd_;
};

}  // namespace cmm::drivers
