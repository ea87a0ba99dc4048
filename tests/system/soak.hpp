// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/system/fault_matrix.hpp"
#include "tests/system/process_watch.hpp"

/// A machine that is left alone for hours: job after job on one simulator, faults of every kind at random instants,
/// each job gone on with until it is done. Watched: memory and open files of both sides, and every sample.
namespace cmm::test {

struct SoakOptions {
    double hours = 8.0;           ///< of machine time
    double speed = 20.0;          ///< of the simulator
    double fault_every_s = 30.0;  ///< mean, machine time
    Wire wire = Wire::tcp;
    std::uint64_t seed = 1;
    std::string watch_file;  ///< CSV of what was seen each second; empty: none
};

struct SoakResult {
    int jobs = 0, resumes = 0;
    double hours = 0.0;                         ///< machine time
    std::map<std::string, int> faults;          ///< how often each kind struck
    std::map<std::string, int> endings;         ///< codes of the errors that runs ended with
    std::vector<Holdings> simulator;            ///< once a second
    std::vector<Holdings> host_at_its_largest;  ///< of each job
    std::uint64_t samples = 0;
    std::vector<std::string> wrong;  ///< what must not be
};

SoakResult soak(const SoakOptions& options);

}  // namespace cmm::test
