// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/error.hpp"

namespace cmm::sim {

struct SimulatorOptions {
    std::string part_file;
    std::string machine_file;  ///< [controller] of it
    std::string map_file;
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;  ///< 0: any free one
    double speed = 1.0;      ///< machine seconds per second; 0: as fast as it goes
    std::uint64_t seed = 1;
    std::string log_file;  ///< the truth of every sample as CSV; empty: none
};

/// A simulated machine with its part, controller and Modbus TCP server, run by a thread of its own from `start` until
/// `stop` or destruction. `port`, `url` and `stop` may be called from any thread.
class Simulator {
  public:
    /// Errors: config_*, input_* (part, machine, map), transport_connect (port), journal_io (log), usage.
    static core::Result<std::unique_ptr<Simulator>> start(const SimulatorOptions& options);
    ~Simulator();
    Simulator(const Simulator&) = delete;
    Simulator& operator=(const Simulator&) = delete;

    std::uint16_t port() const;
    /// The endpoint to connect to: "modbus+tcp://127.0.0.1:1502?unit=1".
    std::string url() const;
    /// Ends the server and writes the log out; a second call does nothing.
    void stop();

  private:
    struct Parts;
    explicit Simulator(std::unique_ptr<Parts> parts);
    std::unique_ptr<Parts> parts_;
};

}  // namespace cmm::sim
