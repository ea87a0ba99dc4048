// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/modbus_codec.hpp"
#include "sim/wire_protocol.hpp"

namespace cmm::sim {

/// Modbus TCP on one connection: a malformed header ends it.
class MbapProtocol final : public WireProtocol {
  public:
    explicit MbapProtocol(RegisterDevice& device) : device_(device) {}
    Progress answer(std::span<const std::uint8_t> in, core::Duration silent_for,
                    std::vector<std::uint8_t>& out) override;

  private:
    RegisterDevice& device_;
};

/// Modbus RTU as a device on a serial line (Modbus over serial line 1.02, 2.4 and 2.5.1): answers its own unit, carries
/// out broadcasts without a reply, keeps silent on a wrong CRC. What does not become a request is dropped when the line
/// has been silent for `silence`.
class RtuProtocol final : public WireProtocol {
  public:
    static constexpr core::Duration silence = std::chrono::milliseconds(20);

    RtuProtocol(RegisterDevice& device, std::uint8_t unit) : device_(device), unit_(unit) {}
    Progress answer(std::span<const std::uint8_t> in, core::Duration silent_for,
                    std::vector<std::uint8_t>& out) override;

  private:
    void carry_out(std::span<const std::uint8_t> request, std::vector<std::uint8_t>& out);
    RegisterDevice& device_;
    std::uint8_t unit_;
};

/// CRC-16/MODBUS over bytes.
std::uint16_t rtu_crc(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace cmm::sim
