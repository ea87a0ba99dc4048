// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/serial_settings.hpp"

namespace cmm::drivers::modbus {

/// How a serial line changes its direction (RS-485 adapters that do not do it by themselves).
struct RtsHandling {
    enum class Level : std::uint8_t { none, up, down };
    Level while_sending = Level::none;
    int delay_us = 0;  ///< before the first and after the last byte; 0: one character time
};

/// One libmodbus context; its source is the only file that includes libmodbus. Error recovery stays off: with it
/// libmodbus loops inside send for as long as the device is gone. One thread.
class ModbusContext {
  public:
    ModbusContext();
    ~ModbusContext();
    ModbusContext(const ModbusContext&) = delete;
    ModbusContext& operator=(const ModbusContext&) = delete;

    /// Each returns why it failed; empty: it is open.
    std::string open_tcp(const std::string& host, const std::string& port, double timeout_ms);
    std::string open_serial(const SerialSettings& serial, const RtsHandling& rts, std::uint8_t unit);
    void close() noexcept;
    bool is_open() const noexcept;
    int fd() const noexcept;
    /// Serial only: unit and PDU, the CRC is added and RTS handled. False: the line is gone or does not take them.
    bool send_serial(std::span<std::uint8_t> unit_and_pdu);

  private:
    struct Handle;
    std::unique_ptr<Handle> handle_;
};

/// Writes to a socket; false when the link broke or the peer takes nothing in for 200 ms. `more` follow at once: the
/// system may put them into one packet.
bool send_to_socket(int fd, std::span<const std::uint8_t> bytes, bool more = false);

}  // namespace cmm::drivers::modbus
