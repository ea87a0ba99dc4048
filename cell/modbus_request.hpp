// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The server's side of Modbus TCP: requests cut out of a byte stream and answered from registers. Pure. After the
/// Modbus application protocol 1.1b3 (6.3, 6.4, 6.6, 6.12, 6.17) and the messaging guide for TCP 1.0b (3.1.3).
namespace cmm::cell {

enum class ModbusException : std::uint8_t {
    none = 0,
    illegal_function = 1,
    illegal_address = 2,
    illegal_value = 3,
    busy = 6,          ///< somebody else writes
    no_target = 0x0B,  ///< a unit that is not here
};

/// What requests act upon. Counts have been checked against the protocol, addresses have not.
class RegisterAccess {
  public:
    virtual ~RegisterAccess() = default;
    virtual ModbusException read(std::size_t address, std::span<std::uint16_t> to) = 0;
    /// All or nothing.
    virtual ModbusException write(std::size_t address, std::span<const std::uint16_t> from) = 0;

  protected:
    RegisterAccess() = default;
    RegisterAccess(const RegisterAccess&) = default;
    RegisterAccess& operator=(const RegisterAccess&) = default;
};

inline constexpr std::size_t longest_adu = 260;

/// The first request among bytes that have arrived.
struct RequestCut {
    enum class Kind : std::uint8_t {
        part,     ///< not whole yet
        request,  ///< `size` bytes of it
        garbled,  ///< no Modbus TCP: where the next request begins is not known
    };
    Kind kind = Kind::part;
    std::size_t size = 0;
};
RequestCut cut_request(std::span<const std::uint8_t> bytes) noexcept;

/// Carries out a whole request (function codes 3, 4, 6, 16, 23) and writes the reply, normal or exception; returns its
/// number of bytes. Answers as `unit`, 0 and 255; others are not here.
std::size_t answer_request(RegisterAccess& registers, std::uint8_t unit, std::span<const std::uint8_t> request,
                           std::span<std::uint8_t, longest_adu> reply);

}  // namespace cmm::cell
