// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "drivers/controller/port.hpp"

/// What the messages of the line protocol say (docs/protocol-line.md). Pure.
namespace cmm::drivers::line {

inline constexpr std::size_t window_points = 10;  ///< path points of one line

/// Errors of the decoders: protocol_mismatch (no controller of this protocol), protocol_invalid.
core::Result<Capabilities> decode_identity(std::string_view text);

struct Status {
    std::uint16_t boot_id = 0;
    controller::StatusBlock block;
};
core::Result<Status> decode_status(std::string_view text);

struct Samples {
    std::uint16_t boot_id = 0;
    controller::FifoBlock block;
    std::vector<core::Sample> samples;  ///< controller sequences, host time 0
};
core::Result<Samples> decode_samples(std::span<const std::uint8_t> payload);

std::string command_body(const controller::CommandBlock& command);
std::string window_body(const controller::Window& window, double lsb_mm);
/// Errors: plan_invalid when a value has no number in the protocol.
core::Status check_point(const PathPoint& point, std::uint64_t index, double lsb_mm);

}  // namespace cmm::drivers::line
