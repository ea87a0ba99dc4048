// SPDX-License-Identifier: Apache-2.0
#include "tests/support/serial_wire.hpp"

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/prctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <stdexcept>

namespace cmm::test {
namespace {

constexpr std::size_t chunk_bytes = 16;  // a UART hands its bytes over at this level of its FIFO

}  // namespace

void SerialWire::End::open() {
    std::array<char, 256> name{};
    termios raw{};
    ::cfmakeraw(&raw);
    raw.c_cflag |= CS8 | CREAD | CLOCAL;
    raw.c_cc[VMIN] = 1;
    if (::openpty(&ours, &theirs, name.data(), &raw, nullptr) != 0) throw std::runtime_error("no pseudo-terminal");
    ::fcntl(ours, F_SETFL, O_NONBLOCK);
    std::filesystem::remove(link);
    std::filesystem::create_symlink(name.data(), link);
}

void SerialWire::End::close() {
    if (ours < 0) return;
    ::close(ours);
    ::close(theirs);  // held, so that programs may come and go
    ours = theirs = -1;
    std::filesystem::remove(link);
}

SerialWire::SerialWire(Options options) : options_(options), rng_(options.seed) {
    std::string pattern = std::filesystem::temp_directory_path() / "cmmlive-wire-XXXXXX";
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = pattern;
    host_.link = host();
    device_.link = device();
    host_.open();
    device_.open();
    thread_ = std::thread([this] { carry(); });
}

SerialWire::~SerialWire() {
    quit_ = true;
    thread_.join();
    host_.close();
    device_.close();
    std::filesystem::remove_all(folder_);
}

void SerialWire::set_faults(double drop, double flip) {
    const std::lock_guard lock(mutex_);
    options_.drop = drop;
    options_.flip = flip;
}

void SerialWire::unplug_host() {
    const std::lock_guard lock(mutex_);
    host_.close();
    to_host_.under_way.clear();
}

void SerialWire::plug_host() {
    const std::lock_guard lock(mutex_);
    host_.open();
}

void SerialWire::spoil(std::vector<std::uint8_t>& bytes) {
    std::vector<std::uint8_t> out;
    for (std::uint8_t byte : bytes) {
        const bool dropped = options_.drop > 0.0 && rng_.uniform(0.0, 1.0) < options_.drop;
        const bool flipped = options_.flip > 0.0 && rng_.uniform(0.0, 1.0) < options_.flip;
        spoilt_ += dropped || flipped ? 1 : 0;
        if (dropped) continue;
        if (flipped) byte = static_cast<std::uint8_t>(byte ^ (1U << rng_.below(8)));
        out.push_back(byte);
    }
    bytes = std::move(out);
}

void SerialWire::take(End& from, Direction& direction) {
    std::array<std::uint8_t, 4096> buffer;
    const auto got = from.ours < 0 ? -1 : ::read(from.ours, buffer.data(), buffer.size());
    if (got <= 0) return;
    auto due = std::max(Clock::now(), direction.free_from);
    for (std::size_t at = 0; at < static_cast<std::size_t>(got); at += chunk_bytes) {
        const std::size_t count = std::min(chunk_bytes, static_cast<std::size_t>(got) - at);
        std::vector<std::uint8_t> bytes(buffer.begin() + static_cast<std::ptrdiff_t>(at),
                                        buffer.begin() + static_cast<std::ptrdiff_t>(at + count));
        if (options_.baud > 0.0) {
            const std::chrono::duration<double> takes(static_cast<double>(count) * options_.bits_per_byte /
                                                      options_.baud);
            due += std::chrono::duration_cast<Clock::duration>(takes);
        }
        spoil(bytes);
        direction.under_way.push_back({due, std::move(bytes)});
    }
    direction.free_from = due;
}

void SerialWire::deliver(End& to, Direction& direction) {
    const auto now = Clock::now();
    std::size_t done = 0;
    for (; done < direction.under_way.size() && direction.under_way[done].due <= now; ++done) {
        const auto& bytes = direction.under_way[done].bytes;
        if (to.ours < 0 || bytes.empty()) continue;
        const auto written = ::write(to.ours, bytes.data(), bytes.size());
        if (written > 0) direction.delivered += static_cast<std::uint64_t>(written);
    }
    direction.under_way.erase(direction.under_way.begin(),
                              direction.under_way.begin() + static_cast<std::ptrdiff_t>(done));
}

void SerialWire::carry() {
    ::prctl(PR_SET_TIMERSLACK, 1UL);  // a line is not late: 50 us are half a byte
    while (!quit_) {
        std::array<pollfd, 2> wait{};
        auto next = Clock::now() + std::chrono::milliseconds(5);  // to see that it shall end, or was plugged in again
        {
            const std::lock_guard lock(mutex_);
            take(host_, to_device_);
            take(device_, to_host_);
            deliver(device_, to_device_);
            deliver(host_, to_host_);
            for (const Direction* direction : {&to_device_, &to_host_})
                if (!direction->under_way.empty()) next = std::min(next, direction->under_way.front().due);
            wait = {{{host_.ours, POLLIN, 0}, {device_.ours, POLLIN, 0}}};
        }
        const auto left = std::max(next - Clock::now(), Clock::duration::zero());
        const timespec pause{0, std::chrono::nanoseconds(left).count()};
        ::ppoll(wait.data(), wait.size(), &pause, nullptr);
    }
}

}  // namespace cmm::test
