// SPDX-License-Identifier: Apache-2.0
#include "drivers/link_log.hpp"

#include <chrono>
#include <string>
#include <utility>

namespace cmm::drivers {
namespace {

constexpr std::string_view hex_digits = "0123456789abcdef";

}  // namespace

void LinkLog::sent(std::span<const std::uint8_t> bytes) {
    trace('>', bytes);
    const std::lock_guard lock(stats_mutex_);
    stats_.bytes_sent += bytes.size();
}

void LinkLog::received(std::span<const std::uint8_t> bytes) {
    if (bytes.empty()) return;
    trace('<', bytes);
    const std::lock_guard lock(stats_mutex_);
    stats_.bytes_received += bytes.size();
}

void LinkLog::count(const std::function<void(LinkStats&)>& change) {
    const std::lock_guard lock(stats_mutex_);
    change(stats_);
}

LinkStats LinkLog::stats() const {
    const std::lock_guard lock(stats_mutex_);
    return stats_;
}

void LinkLog::note(const std::string& text) {
    if (tracing_) write("# " + text);
    const std::lock_guard lock(stats_mutex_);
    stats_.note = text;
}

void LinkLog::set_trace(std::function<void(std::string_view)> line) {
    const std::lock_guard lock(trace_mutex_);
    tracing_ = static_cast<bool>(line);
    trace_ = std::move(line);
}

void LinkLog::trace(char direction, std::span<const std::uint8_t> bytes) {
    if (!tracing_) return;
    std::string line(1, direction);
    for (const auto byte : bytes) {
        line += ' ';
        line += hex_digits[byte >> 4U];
        line += hex_digits[byte & 15U];
    }
    write(line);
}

void LinkLog::write(const std::string& what) {
    const std::chrono::duration<double> now = std::chrono::steady_clock::now().time_since_epoch();
    const std::string line = std::to_string(now.count()) + " " + what;
    const std::lock_guard lock(trace_mutex_);
    if (trace_) trace_(line);
}

}  // namespace cmm::drivers
