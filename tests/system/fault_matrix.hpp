// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/process.hpp"

/// The fault matrix: a small job on the simulated machine, over a real wire, with one thing going wrong at an instant
/// drawn by the seed; then the same command with --resume until the job is done. Judge: the simulator's own log of the
/// samples, and what it says about the machine coming to rest.
namespace cmm::test {

enum class Wire : std::uint8_t { tcp, rtu, line };
std::string to_string(Wire wire);

/// What may go wrong, and what has to come of it.
struct FaultCase {
    std::string name;                 ///< a plan config/faults/<name>.toml, or a fault of the host
    std::string plan;                 ///< the plan where it is not that of the name
    std::string wait_s = "0";         ///< how long the job waits at rest for what may pass
    std::vector<std::string> errors;  ///< codes that a run may end with; none: it has to finish by itself
    bool finishes = true;             ///< by itself, also where it may end with an error
    double stop_ms = 0.0;             ///< the machine has to stand so long after the fault; 0: it need not stop
    bool lasting = false;             ///< to be waited for before the run is resumed
    bool spares_points = true;        ///< a run that finishes by itself gives the same points as without it
    bool curable = true;              ///< the job can be finished afterwards
    std::string speed = "20";         ///< of the simulator: the job takes about a second
    std::vector<Wire> wires{Wire::tcp, Wire::rtu, Wire::line};
};
std::vector<FaultCase> fault_cases();

/// What came of one run. A text that is not empty says what is wrong.
struct FaultRun {
    bool struck = false;
    bool finished_at_once = false, recovered = false;
    bool moved = false;    ///< when the fault struck
    double rest_ms = 0.0;  ///< until the machine stood
    std::string lost, hung, unsafe, wrong;
    std::string error;  ///< the code that the first run ended with
    bool good() const { return lost.empty() && hung.empty() && unsafe.empty() && wrong.empty(); }
    std::string text() const;
};

/// Everything it writes goes below `folder`.
FaultRun run_fault(const FaultCase& fault, Wire wire, std::uint64_t seed, const TemporaryFolder& folder);

}  // namespace cmm::test
