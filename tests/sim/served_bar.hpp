// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <thread>

#include "sim/register_bank.hpp"
#include "sim/wire_server.hpp"
#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {

/// A controller with a round bar behind a real socket, served by a thread of its own until destruction.
class ServedBar {
  public:
    explicit ServedBar(double speed = 0.0);
    enum class Speaks { modbus_rtu, line };
    /// On a serial port; Modbus unit 1.
    explicit ServedBar(const SerialLine& line, Speaks speaks = Speaks::modbus_rtu);
    ~ServedBar();
    std::uint16_t port() const { return port_; }

  private:
    void serve();
    core::SystemClock clock_;
    Controller controller_;
    RegisterBank bank_;
    std::unique_ptr<WireServer> server_;
    std::uint16_t port_ = 0;
    std::thread thread_;
};

/// The register map of the repository.
RegisterMap repository_map();

/// A plain TCP client: bytes out, bytes in, with a deadline.
class RawClient {
  public:
    explicit RawClient(std::uint16_t port);
    ~RawClient();
    void send(const std::vector<std::uint8_t>& bytes);
    /// The next `count` bytes; fewer when the peer closed or five seconds passed.
    std::vector<std::uint8_t> receive(std::size_t count);
    /// Whether the peer has closed the connection (waits up to five seconds for it).
    bool closed();

  private:
    int socket_ = -1;
};

}  // namespace cmm::sim::test
