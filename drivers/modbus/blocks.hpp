// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/sample.hpp"
#include "drivers/controller/port.hpp"
#include "drivers/modbus/register_map.hpp"

/// The blocks of the register map as values: decoding with every check that a block can be given on its own, and
/// encoding. Pure.
namespace cmm::drivers::modbus {

using controller::CommandBlock;
using controller::FifoBlock;
using controller::StatusBlock;
using controller::Window;

void encode(const RegisterMap& map, const CommandBlock& command, std::span<std::uint16_t> registers);

/// Errors: protocol_invalid (CRC, unknown state).
core::Status check_status(const RegisterMap& map, std::span<const std::uint16_t> registers);
/// Of registers that passed the check.
StatusBlock decode_status(const RegisterMap& map, std::span<const std::uint16_t> registers);

/// Errors: protocol_mismatch (not a controller of this map), protocol_invalid (CRC, values that cannot be).
core::Result<Capabilities> decode_identity(const RegisterMap& map, std::span<const std::uint16_t> registers);

/// Errors: protocol_invalid (count, CRC).
core::Status check_fifo(const RegisterMap& map, std::span<const std::uint16_t> registers);
/// Of registers that passed the check.
FifoBlock decode_fifo(const RegisterMap& map, std::span<const std::uint16_t> registers);
/// Decodes all points of the block; sequence numbers are the controller's, host time is left at 0. `samples` is
/// overwritten.
void decode_samples(const RegisterMap& map, std::span<const std::uint16_t> registers, const FifoBlock& block,
                    std::vector<core::Sample>& samples);

/// A path window: header and points. Returns the number of registers. `points` has at most the controller's path
/// window.
std::size_t encode_window(const RegisterMap& map, const Window& from, double lsb_mm,
                          std::span<std::uint16_t> registers);
/// Points that fit into one write by the map, whatever the controller says.
std::size_t window_points(const RegisterMap& map) noexcept;
/// Samples that one block carries.
std::size_t block_samples(const RegisterMap& map) noexcept;
}  // namespace cmm::drivers::modbus
