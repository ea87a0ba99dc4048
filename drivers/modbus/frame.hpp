// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/modbus/register_map.hpp"

/// Modbus requests built and replies checked, alone and in their TCP frames. Pure.
/// libmodbus writes no usable transaction ids into raw requests and cannot match a late reply (its issue 255), hence
/// our own.
namespace cmm::drivers::modbus {

inline constexpr std::size_t max_pdu = 253;    ///< function code and data, of every transport
inline constexpr std::size_t max_frame = 260;  ///< the same in the longest frame, that of TCP
inline constexpr std::size_t max_rtu_frame = 256;
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
    bool alone = false;  ///< what follows is sent after its reply, and it after all before it
    Outcome outcome = Outcome::not_sent;
    std::uint8_t exception = 0;

    std::span<std::uint16_t> to_write() { return {written.data(), write_count}; }
    std::span<const std::uint16_t> reply() const { return {read.data(), read_count}; }
};

namespace exception_code {
inline constexpr std::uint8_t illegal_value = 3;
inline constexpr std::uint8_t busy = 6;
}  // namespace exception_code

/// The bytes of a request from the function code on; returns their number.
std::size_t encode_pdu(const Transaction& request, std::span<std::uint8_t, max_pdu> pdu) noexcept;
/// Number of bytes of the reply that is asked for, from the function code on.
std::size_t reply_size(const Transaction& request) noexcept;
/// Takes a reply, from the function code on, into the transaction: ok, exception or invalid.
void take_reply(std::span<const std::uint8_t> pdu, Transaction& request) noexcept;

/// Modbus/TCP: a header with the transaction id before the PDU. Returns the frame's number of bytes.
std::size_t tcp_frame(std::uint16_t id, std::uint8_t unit, std::span<const std::uint8_t> pdu,
                      std::span<std::uint8_t, max_frame> frame) noexcept;
/// The first frame among bytes that have arrived.
struct TcpCut {
    enum class Kind : std::uint8_t {
        part,     ///< not whole yet
        frame,    ///< `size` bytes of it
        garbled,  ///< no header: the byte stream is out of step and the link is lost
    };
    Kind kind = Kind::part;
    std::size_t size = 0;
};
TcpCut cut_tcp(std::span<const std::uint8_t> bytes) noexcept;
/// Of a whole frame.
std::uint16_t tcp_id(std::span<const std::uint8_t> frame) noexcept;
std::span<const std::uint8_t> tcp_pdu(std::span<const std::uint8_t> frame) noexcept;

}  // namespace cmm::drivers::modbus
