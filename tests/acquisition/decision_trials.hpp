// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/section_result.hpp"
#include "fitting/error_fields.hpp"
#include "support/families.hpp"

/// How often decisions are wrong of blades that lie exactly at a limit: the real fit, the real rule, the real watch.
/// Seen as just inside, every rejection is false; seen as just outside, every acceptance.
namespace cmm::acquisition::decisions {

struct Rates {
    std::size_t trials = 0, accepted = 0, rejected = 0, refused = 0;
    std::size_t held = 0, intervals = 0;             ///< of U95, how many hold the limit, which is the truth
    double error = 0.0, squares = 0.0, guard = 0.0;  ///< sums of value less limit, its square, and the guard bands

    double accept_share() const { return trials > 0 ? static_cast<double>(accepted) / static_cast<double>(trials) : 0; }
    double reject_share() const { return trials > 0 ? static_cast<double>(rejected) / static_cast<double>(trials) : 0; }
    void count(Decision decision);
    void add(const Rates& other);
};
/// By the name of what lies at its limit: "chord, upper", "profile_suction, all of it, outside", "while measuring,
/// ...".
using Table = std::map<std::string, Rates>;

struct Task {
    fitting::families::Family family = fitting::families::Family::compressor;
    std::uint64_t first_seed = 1, blades = 100;
    std::vector<double> sigmas_mm{1e-3};
    std::size_t points = 600;
    double bad_share = 0.0;
    fitting::SystematicErrors errors;  ///< of the machines that measure them, one for each blade; none
};
/// One table for each noise. Deterministic.
std::vector<Table> run(const Task& task);

/// Interval of a share of which `count` of `trials` were seen, which misses it with probability `outside` at most:
/// Clopper and Pearson 1934.
std::pair<double, double> binomial_interval(std::size_t count, std::size_t trials, double outside = 0.05);

}  // namespace cmm::acquisition::decisions
