// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/error.hpp"
#include "sim/modbus_codec.hpp"

namespace cmm::sim {

/// A Modbus TCP server on plain sockets: several clients, requests of one client answered in order however they are cut
/// into segments; a malformed frame closes the connection. `run` is called by one thread, which alone touches the
/// device; `stop` may be called from any thread.
class ModbusServer {
  public:
    /// Called after each round of requests; returns after how many milliseconds it wants to be called again at the
    /// latest.
    using Tick = std::function<int()>;

    /// Binds and listens. Port 0: any free one. Errors: transport_connect.
    static core::Result<std::unique_ptr<ModbusServer>> listen(const std::string& address, std::uint16_t port);
    ~ModbusServer();
    ModbusServer(const ModbusServer&) = delete;
    ModbusServer& operator=(const ModbusServer&) = delete;

    std::uint16_t port() const { return port_; }
    /// Serves until `stop`.
    void run(RegisterDevice& device, const Tick& tick);
    void stop() noexcept;

  private:
    struct Client;
    struct Wires;
    ModbusServer();
    void wait(int timeout_ms);
    void accept_clients();

    std::unique_ptr<Wires> wires_;
    std::uint16_t port_ = 0;
    std::atomic<bool> stopping_{false};
};

}  // namespace cmm::sim
