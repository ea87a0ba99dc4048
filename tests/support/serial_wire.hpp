// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/rng.hpp"

namespace cmm::test {

/// A serial wire between two pseudo-terminals, which alone know neither speed nor noise: delivers each byte no earlier
/// than a line of `baud` would and spoils bytes at a rate. A thread of its own; all functions from any thread.
class SerialWire {
  public:
    struct Options {
        double baud = 0.0;  ///< 0: as fast as it goes
        double bits_per_byte = 10.0;
        double drop = 0.0, flip = 0.0;  ///< chance of each byte
        std::uint64_t seed = 1;
    };
    SerialWire() : SerialWire(Options{}) {}
    explicit SerialWire(Options options);
    ~SerialWire();
    SerialWire(const SerialWire&) = delete;
    SerialWire& operator=(const SerialWire&) = delete;

    /// Names of the ends, to be opened as serial ports; they stay the same when the wire is plugged in again.
    std::string host() const { return folder_ + "/host"; }
    std::string device() const { return folder_ + "/device"; }
    void set_faults(double drop, double flip);
    /// Pulls the host's adapter (its port is gone), and puts it back (as another pseudo-terminal).
    void unplug_host();
    void plug_host();
    std::uint64_t bytes_to_device() const { return to_device_.delivered; }
    std::uint64_t bytes_to_host() const { return to_host_.delivered; }
    std::uint64_t spoilt() const { return spoilt_; }

  private:
    using Clock = std::chrono::steady_clock;
    struct End {
        int ours = -1, theirs = -1;
        std::string link;
        void open();
        void close();
    };
    struct Direction {
        struct Chunk {
            Clock::time_point due;
            std::vector<std::uint8_t> bytes;
        };
        std::vector<Chunk> under_way;
        Clock::time_point free_from{};
        std::atomic<std::uint64_t> delivered{0};
    };
    void carry();
    void take(End& from, Direction& direction);
    void deliver(End& to, Direction& direction);
    void spoil(std::vector<std::uint8_t>& bytes);

    Options options_;
    std::string folder_;
    std::mutex mutex_;
    core::Rng rng_;
    End host_, device_;
    Direction to_device_, to_host_;
    std::atomic<std::uint64_t> spoilt_{0};
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

}  // namespace cmm::test
