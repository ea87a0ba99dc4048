// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace cmm::drivers {

/// Health of a link as data: counters since the machine was made, times in microseconds. A plain value.
struct LinkStats {
    /// Bucket k counts round trips of [2^k, 2^(k+1)) us; the last one also everything slower.
    static constexpr std::size_t buckets = 20;

    std::uint64_t ok = 0;          ///< exchanges answered as they should be (exceptions included)
    std::uint64_t timeouts = 0;    ///< no reply in time
    std::uint64_t closed = 0;      ///< the connection broke during an exchange
    std::uint64_t invalid = 0;     ///< replies that make no sense: framing, length, block CRC
    std::uint64_t exceptions = 0;  ///< Modbus exceptions, busy among them
    std::uint64_t stale = 0;       ///< replies to requests that had been given up
    std::uint64_t retries = 0;
    std::uint64_t reconnects = 0;
    std::uint64_t half_answered = 0;      ///< batches in flight of which some requests were answered and others not
    std::string note;                     ///< what whoever looks after the link should know; empty: nothing
    std::uint64_t duplicate_samples = 0;  ///< received again after a lost reply and dropped
    std::uint64_t bytes_sent = 0;
    std::uint64_t bytes_received = 0;
    std::uint64_t stops = 0;    ///< stop requests put on the wire
    double last_stop_us = 0.0;  ///< from the call of stop() to the stop being on the wire
    double last_round_trip_us = 0.0;
    double max_round_trip_us = 0.0;
    double total_round_trip_us = 0.0;
    std::array<std::uint64_t, buckets> histogram{};

    std::uint64_t errors() const noexcept { return timeouts + closed + invalid; }
    void add_round_trip(double us) noexcept {
        ++ok;
        last_round_trip_us = us;
        total_round_trip_us += us;
        if (us > max_round_trip_us) max_round_trip_us = us;
        std::size_t bucket = 0;
        for (double upper = 2.0; us >= upper && bucket + 1 < buckets; upper *= 2.0)
            ++bucket;
        ++histogram[bucket];
    }
};

}  // namespace cmm::drivers
