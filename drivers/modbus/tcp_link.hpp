// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/modbus/frame.hpp"
#include "drivers/modbus/link.hpp"
#include "drivers/modbus/modbus_context.hpp"

namespace cmm::drivers::modbus {

/// A Modbus TCP connection through libmodbus, with frames and transaction ids of our own. One thread.
class TcpLink final : public Link {
  public:
    TcpLink(std::string host, std::uint16_t port, std::uint8_t unit);

    std::string open(double timeout_ms) override;
    void close() noexcept override { context_.close(); }
    bool is_open() const noexcept override { return context_.is_open(); }
    int fd() const noexcept override { return context_.fd(); }
    std::span<const std::uint8_t> send(std::uint16_t id, std::span<const std::uint8_t> pdu) override;
    Arrival receive() override;
    bool has_part() const noexcept override { return false; }  // libmodbus waits for the rest itself
    bool resync() override { return false; }
    bool overlaps() const noexcept override { return true; }
    double wire_ms(std::size_t) const noexcept override { return 0.0; }

  private:
    std::string host_, port_;
    std::uint8_t unit_;
    ModbusContext context_;
    std::array<std::uint8_t, max_frame> sent_{}, received_{};
};

}  // namespace cmm::drivers::modbus
