// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "core/error.hpp"
#include "sim/descriptor.hpp"

namespace cmm::sim {

/// A serial line that the simulated controller hangs on. A plain value.
struct SerialLine {
    enum class Parity : std::uint8_t { none, even, odd };
    std::string path;  ///< the device; of a pty: the link to the end for the host, which is made
    bool pty = false;  ///< make a pseudo-terminal instead of opening a device
    int baud = 115200;
    Parity parity = Parity::none;
    int stop_bits = 1;
};

/// An open line. Of a pty both ends are held, so that hosts may come and go; the link is removed at the end.
class OpenLine {
  public:
    /// Errors: transport_connect (with the system's reason), usage (a speed that ports do not have).
    static core::Result<OpenLine> open(const SerialLine& line);
    OpenLine(OpenLine&& other) noexcept;
    OpenLine& operator=(OpenLine&& other) noexcept;
    ~OpenLine();
    /// Non-blocking.
    int fd() const { return ours_.get(); }

  private:
    OpenLine() = default;
    Descriptor ours_, hosts_;
    std::string link_;
};

}  // namespace cmm::sim
