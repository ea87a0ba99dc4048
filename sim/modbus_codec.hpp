// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace cmm::sim {

/// Modbus exception codes that a device answers with; `none` is success.
enum class ModbusException : std::uint8_t {
    none = 0,
    illegal_function = 1,
    illegal_address = 2,
    illegal_value = 3,
    busy = 6
};

/// Holding registers behind a Modbus server.
class RegisterDevice {
  public:
    virtual ~RegisterDevice() = default;
    /// Fills `to` with the registers from `address` on.
    virtual ModbusException read(std::size_t address, std::span<std::uint16_t> to) = 0;
    /// All of `from` or nothing.
    virtual ModbusException write(std::size_t address, std::span<const std::uint16_t> from) = 0;

  protected:
    RegisterDevice() = default;
    RegisterDevice(const RegisterDevice&) = default;
    RegisterDevice& operator=(const RegisterDevice&) = default;
};

/// Modbus TCP framing as the Modbus messaging guide 1.0b, 3.1.3 has it: transaction, protocol 0, length, unit, then the
/// PDU.
namespace mbap {
inline constexpr std::size_t header = 7;
inline constexpr std::size_t longest_pdu = 253;

struct Frame {
    std::span<const std::uint8_t> header;  ///< 7 bytes, as received
    std::span<const std::uint8_t> pdu;     ///< at least 1 byte
    std::size_t size = 0;                  ///< of the whole, in bytes
};
enum class Parse : std::uint8_t { complete, partial, malformed };
/// The first frame of a byte stream. `malformed`: not protocol 0, or a length that no PDU has; the stream is lost.
Parse next_frame(std::span<const std::uint8_t> bytes, Frame& frame);
}  // namespace mbap

/// Carries out one request PDU (function codes 3, 4, 6, 16, 23) and appends the reply PDU, normal or exception.
void answer_pdu(RegisterDevice& device, std::span<const std::uint8_t> request, std::vector<std::uint8_t>& reply);

/// Answers one frame: appends header and reply PDU.
void answer_frame(RegisterDevice& device, const mbap::Frame& frame, std::vector<std::uint8_t>& reply);

}  // namespace cmm::sim
