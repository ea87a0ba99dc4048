// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/modbus/frame.hpp"
#include "drivers/modbus/link.hpp"
#include "drivers/modbus/modbus_context.hpp"

namespace cmm::drivers::modbus {

/// A Modbus TCP connection opened by libmodbus, with frames and transaction ids of our own on its socket: many requests
/// may be under way, and many replies come in one piece. One thread.
class TcpLink final : public Link {
  public:
    TcpLink(std::string host, std::uint16_t port, std::uint8_t unit);

    std::string open(double timeout_ms) override;
    void close() noexcept override;
    bool is_open() const noexcept override { return context_.is_open(); }
    int fd() const noexcept override { return context_.fd(); }
    std::span<const std::uint8_t> send(std::uint16_t id, std::span<const std::uint8_t> pdu, bool more) override;
    Arrival receive() override;
    bool has_part() const noexcept override { return filled_ > taken_; }
    bool resync() override { return false; }
    bool overlaps() const noexcept override { return true; }
    double wire_ms(std::size_t) const noexcept override { return 0.0; }

  private:
    bool read_some() noexcept;
    std::span<const std::uint8_t> waiting() const noexcept {
        return std::span(buffer_).subspan(taken_, filled_ - taken_);
    }

    std::string host_, port_;
    std::uint8_t unit_;
    ModbusContext context_;
    std::array<std::uint8_t, max_frame> sent_{};
    std::array<std::uint8_t, 16 * 1024> buffer_{};
    std::size_t filled_ = 0, taken_ = 0;  // of the buffer: handed out already
};

}  // namespace cmm::drivers::modbus
