// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "sim/serial_line.hpp"

namespace cmm::sim {

/// One way on which the simulated controller can be reached.
struct Listen {
    enum class Kind : std::uint8_t { modbus_tcp, modbus_rtu, line_serial };
    Kind kind = Kind::modbus_tcp;
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;  ///< 0: any free one
    SerialLine line;         ///< of the serial kinds
    std::uint8_t unit = 1;   ///< answered to on a Modbus line
};

struct SimulatorOptions {
    std::string part_file;
    std::string machine_file;  ///< [controller] of it
    std::string map_file;
    std::vector<Listen> listen{Listen{}};
    double speed = 1.0;  ///< machine seconds per second; 0: as fast as it goes
    std::uint64_t seed = 1;
    std::string log_file;    ///< the truth of every sample as CSV; empty: none
    std::string fault_file;  ///< what breaks and when; empty: nothing
    /// Told, on the simulator's thread, a line for each fault that strikes and each stop after it.
    std::function<void(const std::string&)> on_fault;
    /// Told, on the simulator's thread, when a stop arrives: what a measurement of its way ends with.
    std::function<void()> on_stop;
};

/// A simulated machine with its part, controller and server, run by a thread of its own from `start` until `stop` or
/// destruction. `port`, `urls` and `stop` may be called from any thread.
class Simulator {
  public:
    /// Errors: config_*, input_* (part, machine, map, faults), transport_connect (port, device), journal_io (log),
    /// usage.
    static core::Result<std::unique_ptr<Simulator>> start(const SimulatorOptions& options);
    ~Simulator();
    Simulator(const Simulator&) = delete;
    Simulator& operator=(const Simulator&) = delete;

    /// Of the first TCP listener; 0: there is none.
    std::uint16_t port() const;
    /// The endpoints to connect to, in the order of `listen`: "modbus+tcp://127.0.0.1:1502?unit=1".
    const std::vector<std::string>& urls() const;
    const std::string& url() const { return urls().front(); }
    /// Ends the server and writes the log out; a second call does nothing.
    void stop();

  private:
    struct Parts;
    explicit Simulator(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

}  // namespace cmm::sim
