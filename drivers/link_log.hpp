// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <string_view>

#include "drivers/link_stats.hpp"

namespace cmm::drivers {

/// The counters and the trace of one link. Any thread.
class LinkLog {
  public:
    void sent(std::span<const std::uint8_t> bytes);
    void received(std::span<const std::uint8_t> bytes);
    void count(const std::function<void(LinkStats&)>& change);
    LinkStats stats() const;
    /// What whoever looks after the link should know: in the trace and in the statistics, where the newest stays.
    void note(const std::string& text);
    /// Every message as one line: seconds of the steady clock, direction, hexadecimal bytes. {} ends it.
    void set_trace(std::function<void(std::string_view)> line);

  private:
    void trace(char direction, std::span<const std::uint8_t> bytes);
    void write(const std::string& what);

    mutable std::mutex stats_mutex_;
    LinkStats stats_;
    std::mutex trace_mutex_;
    std::function<void(std::string_view)> trace_;
    std::atomic<bool> tracing_{false};
};

}  // namespace cmm::drivers
