// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tests/support/process.hpp"

namespace cmm::test {

/// LinuxCNC itself as the controller of a measuring machine, whose HAL file computes what the probe meets: a ball and a
/// bar (tests/peers/linuxcnc/bodies.hal). Headless, without a real-time kernel, in namespaces of its own; ends with the
/// object.
class LinuxcncPeer {
  public:
    /// What is in the way of starting it: no LinuxCNC, not root. Empty: nothing, and this process and its children now
    /// have a network of their own, since linuxcncrsh listens on every interface there is.
    static std::string obstacle();
    /// Starts it, from the project's root; its output goes to files `log_stem`.out and .err. Whether it listens yet is
    /// for who connects.
    explicit LinuxcncPeer(const std::string& log_stem);

    static constexpr const char* url = "linuxcnc://127.0.0.1:5007";
    /// Half a servo cycle: what a latch in it is late on the mean (docs/linuxcnc.md).
    static constexpr double latch_delay_us = 500.0;
    bool running() { return process_.running(); }
    /// What it printed.
    std::string said() const { return process_.out() + process_.err(); }

  private:
    Process process_;
};

}  // namespace cmm::test
