// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>

namespace cmm::test {

/// Passes bytes between one TCP client after another and a serial port, as a device server does. A thread of its own.
class SerialGateway {
  public:
    explicit SerialGateway(const std::string& serial_port);
    ~SerialGateway();
    SerialGateway(const SerialGateway&) = delete;
    SerialGateway& operator=(const SerialGateway&) = delete;
    std::uint16_t port() const { return port_; }

  private:
    void serve();
    int serial_, listener_;
    std::uint16_t port_ = 0;
    std::atomic<bool> quit_{false};
    std::thread thread_;
};

}  // namespace cmm::test
