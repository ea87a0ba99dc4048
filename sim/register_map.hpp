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
    struct Identity : Block {
        std::size_t magic, map_version, firmware, model, serial, lsb_nm, sample_rate_hz, fifo_depth, path_capacity,
            path_window, watchdog_ms, capabilities, deflection_lsb_um, limit_min, limit_max, max_speed_um_s,
            max_accel_um_s2, boot_id, crc;
    };
    struct Status : Block {
        std::size_t state, heartbeat, flags, fault, command_seq, command_state, result, values, active_path,
            path_recorded, path_received, newest_seq, acked_seq, position, fifo_level, time_us, owner, crc;
    };
    struct Command : Block {
        std::size_t seq, opcode, owner, args, crc;
    };
    struct Path : Block {  // length = the largest window
        std::size_t header, path, first_index, count, crc, point_length;
    };
    struct Exchange : Block {
        std::size_t watchdog, ack_seq, from_seq;
    };
    struct Fifo : Block {
        std::size_t state, heartbeat, path, first_seq, newest_seq, count, flags, time_us, crc, points, point_length;
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
    std::size_t path_window = 0;  ///< path points of one write
    std::size_t fifo_window = 0;  ///< samples of one read
};

/// Errors: input_missing, config_syntax, config_invalid (a key missing, a field outside its block, blocks that
/// overlap).
core::Result<RegisterMap> load_register_map(const std::string& file);

}  // namespace cmm::sim
