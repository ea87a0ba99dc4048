// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "drivers/modbus/frame.hpp"

namespace cmm::drivers::modbus {

/// One Modbus TCP connection through libmodbus (the only file that includes it): connecting, cutting the byte stream
/// into frames, closing. One thread.
class TcpLink {
  public:
    TcpLink(std::string host, std::uint16_t port);
    ~TcpLink();
    TcpLink(const TcpLink&) = delete;
    TcpLink& operator=(const TcpLink&) = delete;

    /// Blocks for the timeout at most (and for the name service). Returns why it failed; empty: it is open.
    std::string open(double timeout_ms);
    void close() noexcept;
    bool is_open() const noexcept { return context_ != nullptr; }
    /// To wait for; valid while open.
    int fd() const noexcept;
    /// False: the link broke.
    bool send(std::span<const std::uint8_t> frame);
    /// The frame of which the first bytes have arrived, valid until the next call; empty: the link broke or the frame
    /// did.
    std::span<const std::uint8_t> receive();

  private:
    struct Context;
    std::string failure(int error, double timeout_ms) const;

    std::string host_, port_;
    std::unique_ptr<Context> context_;
    std::array<std::uint8_t, max_frame> frame_{};
};

}  // namespace cmm::drivers::modbus
