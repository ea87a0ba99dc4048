// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/system/simulated_machine.hpp"

namespace cmm::test {

/// `machine`: a URL or a machine file.
std::vector<std::string> scan_command(const std::string& machine, const std::string& part, const std::string& out,
                                      bool resume);
std::vector<std::string> scan_command(const SimulatedMachine& machine, const std::string& part, const std::string& out,
                                      bool resume);

/// Bytes in the simulator's log of recorded samples, which grows while it scans; a line has some 100.
std::uintmax_t log_size(const SimulatedMachine& machine);

/// Every sample in the run file, exactly once, with the counts that the simulator logged.
void expect_every_sample_once(const std::string& run_file, const std::string& log_file);

/// "idle", "scanning", "stopped", ... and why, as `cmmlive doctor` sees it; empty when it does not answer.
struct SeenState {
    std::string state, fault;
};
SeenState state_of(const SimulatedMachine& machine);

}  // namespace cmm::test
