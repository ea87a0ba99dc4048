// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "fitting/error_fields.hpp"
#include "support/families.hpp"

/// How often the 95 % intervals of characteristics hold the truth.
namespace cmm::fitting::coverage {

struct Tally {
    std::size_t held = 0, trials = 0, refused = 0;
    double squares = 0.0;         ///< of error over standard uncertainty
    double error = 0.0, u = 0.0;  ///< sums of the error and of the standard uncertainty
    double error_squares = 0.0, u_squares = 0.0;

    double share() const { return trials > 0 ? static_cast<double>(held) / static_cast<double>(trials) : 0.0; }
};
using Tallies = std::map<std::string, Tally>;

struct Task {
    families::Family family = families::Family::compressor;
    std::uint64_t first_seed = 1, blades = 100;
    std::vector<double> sigmas_mm{1e-3};
    std::size_t points = 600;
    double bad_share = 0.0;
    std::size_t sections = 3;  ///< of one blade, for its alignment
    SystematicErrors errors;   ///< of the machines that measure them, one for each blade; none
};
/// One tally for each noise, by the names of the characteristics. Deterministic.
std::vector<Tallies> run(const Task& task);

/// Of every sixth of 25 sections of twisted blades, each compensated by the surface of all.
struct Compensated {
    Tallies between, ends;  ///< the lowest and the highest section lean on neighbours to one side
};
/// The same for them, without the systematic errors and the alignments of the task.
std::vector<Compensated> run_compensated(const Task& task);

}  // namespace cmm::fitting::coverage
