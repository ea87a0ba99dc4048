// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>

#include "drivers/modbus/frame.hpp"
#include "drivers/modbus/link.hpp"
#include "drivers/modbus/modbus_context.hpp"
#include "drivers/serial_settings.hpp"

namespace cmm::drivers::modbus {

struct RtuOptions {
    SerialSettings serial;  ///< the port; without a device the line is behind a gateway
    RtsHandling rts;
    std::string host;  ///< of a gateway that passes RTU frames on unchanged ("RTU over TCP")
    std::uint16_t port = 0;
    std::uint8_t unit = 1;
    double gap_ms = 0.0;  ///< silence between a reply and the next request

    /// 3.5 characters, from 19200 baud on 1.75 ms (Modbus over serial line 1.02, 2.5.1.1).
    static double standard_gap_ms(const SerialSettings& serial) noexcept;
};

/// Modbus RTU on a serial port, opened and written by libmodbus, or through a gateway. A reply carries no id: it
/// belongs to the request sent last, as long as the bus keeps to one request at a time. One thread.
class RtuLink final : public Link {
  public:
    explicit RtuLink(RtuOptions options) : options_(std::move(options)) {}

    std::string open(double timeout_ms) override;
    void close() noexcept override { context_.close(); }
    bool is_open() const noexcept override { return context_.is_open(); }
    int fd() const noexcept override { return context_.fd(); }
    std::span<const std::uint8_t> send(std::uint16_t id, std::span<const std::uint8_t> pdu, bool more) override;
    Arrival receive() override;
    bool has_part() const noexcept override { return filled_ > taken_; }
    bool resync() override;
    bool overlaps() const noexcept override { return false; }
    double wire_ms(std::size_t bytes) const noexcept override;

  private:
    using SteadyClock = std::chrono::steady_clock;
    bool on_serial() const noexcept { return !options_.serial.device.empty(); }
    bool readable(int timeout_ms) const noexcept;
    bool read_some() noexcept;
    void drop(std::size_t bytes) noexcept;
    void discard_input() noexcept;
    std::span<const std::uint8_t> received() const noexcept { return std::span(buffer_).first(filled_); }

    RtuOptions options_;
    ModbusContext context_;
    std::uint16_t sent_id_ = 0;
    std::array<std::uint8_t, max_frame> sent_{};
    std::array<std::uint8_t, 2 * max_frame> buffer_{};
    std::size_t filled_ = 0;
    std::size_t taken_ = 0;               // of the buffer: the reply handed out last
    SteadyClock::time_point quiet_from_;  // the line is silent since then, as far as we know
};

}  // namespace cmm::drivers::modbus
