// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/error.hpp"

namespace cmm::sim {

/// Where the simulated controller keeps what (config/maps/*.toml, explained in docs/protocol-modbus.md). Block
/// addresses are holding registers counted from 0, everything else offsets in the block. A plain value.
struct RegisterMap {
    struct Block {
        std::size_t address = 0;
        std::size_t length = 0;
        /// Whether [at, at + count) lies in the block.
        bool holds(std::size_t at, std::size_t count) const { return at >= address && at + count <= address + length; }
    };
    /// A number in `words` registers, or in some bits of one.
    struct Place {
        std::size_t at = 0;
        std::size_t words = 1;
        unsigned bit = 0;
        unsigned bits = 16;
    };
    struct Identity : Block {
        std::size_t magic, map_version, firmware, model, serial, lsb_nm, sample_rate_hz, fifo_depth, path_capacity,
            path_window, watchdog_ms, capabilities, deflection_lsb_um, limit_min, limit_max, max_speed_um_s,
            max_accel_um_s2, boot_id, crc;
    };
    struct Status : Block {
        Place state, flags, fault, command_state, result, path_recorded, path_received, fifo_level;
        std::size_t heartbeat, command_seq, values, active_path, newest_seq, acked_seq, position, time_us, owner, crc;
    };
    struct Command : Block {
        std::size_t seq, opcode, owner, args, crc;
    };
    struct Path : Block {  // length = the largest window
        std::size_t header, path, first_index, count, crc, point_length;
        std::size_t position, normal, speed, flags;  // of a point
    };
    struct Exchange : Block {
        std::size_t watchdog, ack_seq, from_seq;
    };
    struct Fifo : Block {
        Place state, flags;
        std::size_t heartbeat, path, first_seq, newest_seq, count, time_us, crc, points, point_length;
        std::size_t position, dt, quality;  // of a point
    };

    std::uint16_t version = 1;
    bool big_words = true;
    Identity identity{};
    Status status{};
    Command command{};
    Block stop{};
    Path path{};
    Exchange exchange{};
    Fifo fifo{};
    double count_mm = 0.0;  ///< size of a count; 0: the machine's own
    double speed_mm_s = 0.01;
    double normal = 32767.0;
    std::int64_t dt_us = 10;
    std::size_t path_window = 0;  ///< path points of one write
    std::size_t fifo_window = 0;  ///< samples of one read
};

/// Errors: input_missing, config_syntax, config_invalid (a key missing, a field outside its block, blocks that
/// overlap).
core::Result<RegisterMap> load_register_map(const std::string& file);

}  // namespace cmm::sim
