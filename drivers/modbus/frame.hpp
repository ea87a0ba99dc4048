// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/modbus/register_map.hpp"

/// Modbus/TCP frames: requests built, replies checked and matched by transaction id. Pure.
/// libmodbus writes no usable transaction ids into raw requests and cannot match a late reply (its issue 255), hence
/// our own.
namespace cmm::drivers::modbus {

inline constexpr std::size_t max_frame = 260;
inline constexpr std::size_t max_exchange_write = 121;  ///< registers written by one FC 23

/// One request to the controller and what became of it. Filled by the caller, who leaves it alone while the bus has it.
struct Transaction {
    enum class Kind : std::uint8_t { read, write, write_single, exchange };  ///< FC 3, 16, 6, 23
    enum class Outcome : std::uint8_t { not_sent, ok, exception, timeout, closed, invalid };

    Kind kind = Kind::read;
    std::uint16_t write_address = 0, write_count = 0;
    std::uint16_t read_address = 0, read_count = 0;
    std::array<std::uint16_t, max_write> written{};
    std::array<std::uint16_t, max_read> read{};
    /// Whether the registers read hold together (CRC); null: nothing to check. A reply that fails is asked for again.
    core::Status (*check)(const RegisterMap&, std::span<const std::uint16_t>) = nullptr;
    Outcome outcome = Outcome::not_sent;
    std::uint8_t exception = 0;

    std::span<std::uint16_t> to_write() { return {written.data(), write_count}; }
    std::span<const std::uint16_t> reply() const { return {read.data(), read_count}; }
};

namespace exception_code {
inline constexpr std::uint8_t illegal_value = 3;
inline constexpr std::uint8_t busy = 6;
}  // namespace exception_code

/// The bytes of a request; returns their number.
std::size_t encode_request(const Transaction& request, std::uint16_t id, std::uint8_t unit,
                           std::span<std::uint8_t, max_frame> frame) noexcept;

std::uint16_t id_of(std::span<const std::uint8_t> frame) noexcept;
/// Whether the header's length fits the bytes: if not, the byte stream is out of step and the link is lost.
bool header_fits(std::span<const std::uint8_t> frame) noexcept;
/// Takes a reply with the right id into the transaction: ok, exception or invalid.
void take_reply(std::span<const std::uint8_t> frame, Transaction& request) noexcept;

}  // namespace cmm::drivers::modbus
