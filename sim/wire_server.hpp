// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "core/error.hpp"
#include "sim/serial_line.hpp"
#include "sim/wire_protocol.hpp"

namespace cmm::sim {

/// Serves any number of TCP listeners and serial lines, each with its protocol: requests of one connection are answered
/// in order however they are cut into pieces. A serial device that goes away is opened again when it is back. Set up
/// first; then `run` is called by one thread, which alone touches what the protocols touch; `stop` may be called from
/// any thread.
class WireServer {
  public:
    /// Called after each round of requests; returns after how many milliseconds it wants to be called again at the
    /// latest.
    using Tick = std::function<int()>;
    using Speak = std::function<std::unique_ptr<WireProtocol>()>;

    /// Errors: transport_connect (no descriptors left).
    static core::Result<std::unique_ptr<WireServer>> make();
    ~WireServer();
    WireServer(const WireServer&) = delete;
    WireServer& operator=(const WireServer&) = delete;

    /// Binds and listens; returns the port. Port 0: any free one. Errors: transport_connect, usage.
    core::Result<std::uint16_t> listen(const std::string& address, std::uint16_t port, Speak speak);
    /// Errors: transport_connect, usage.
    core::Status open(const SerialLine& line, Speak speak);

    /// Serves until `stop`.
    void run(const Tick& tick);
    void stop() noexcept;

  private:
    struct Connection;
    struct Listener;
    struct Port;
    struct Wires;
    WireServer();
    void wait(int timeout_ms);
    void accept_clients(Listener& listener);
    void reopen(Port& port);

    std::unique_ptr<Wires> wires_;
    std::atomic<bool> stopping_{false};
};

}  // namespace cmm::sim
