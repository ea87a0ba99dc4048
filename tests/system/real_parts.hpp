// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tests/support/process.hpp"

/// Blades that nobody on this project made, as part files for the simulator and the host (../shared/data, read in
/// place).
namespace cmm::test {

struct RealPart {
    std::string name;
    std::string actual;   ///< the [actual] geometry, TOML lines
    std::string nominal;  ///< the [nominal] lines of the run with a nominal
    std::vector<double> heights_mm;
    double ball_radius_mm = 1.0;
    double pitch_mm = 0.4;
};

/// Where the data is; empty when it is not there.
std::string real_data_folder();

/// The engine blade's mesh, hannover-4ac rotor 1 and stator 1, rotor37. Converted files go to `folder`.
std::vector<RealPart> real_parts(const TemporaryFolder& folder);

/// Writes the part file; `unknown`: nominal "none". With noise of 1 um and 1 % bad points.
std::string write_part(const RealPart& part, const TemporaryFolder& folder, bool unknown);

}  // namespace cmm::test
