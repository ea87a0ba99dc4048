// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "acquisition/measure_again.hpp"
#include "core/rng.hpp"
#include "tests/acquisition/decision_subject.hpp"
#include "tests/acquisition/decision_trials.hpp"

/// Sections that are measured until they are decided, on simulated blades: the real planner, fit, rule and watch.
namespace cmm::acquisition::decisions {

/// Touches a blade whose surface lies `height_mm(t)` outside its outline.
class Probe {
  public:
    Probe(const fitting::families::Blade& blade, std::function<double(double)> height_mm, double sigma_mm,
          std::uint64_t seed);
    void measure(std::span<const drivers::PathPoint> path, std::uint8_t pass, std::vector<RecordedPoint>& points);

  private:
    const fitting::families::Blade& blade_;
    std::function<double(double)> height_mm_;
    double sigma_mm_;
    core::Rng rng_;
};

struct Measured {
    SectionResult result;
    std::size_t points = 0, passes = 0;
    double seconds = 0.0;
    bool early = false;  ///< called out while the lap was measured
};
/// `setup.gate.rule.looks` is one more than `bound.passes`. With `early_stop` the lap ends where the watch says so.
Measured measure_until_decided(const SectionSetup& setup, const PlannedPath& lap, const UntilDecided& bound,
                               Probe& probe, bool early_stop);

/// As `run`, but each blade has one characteristic at its limit, in turn, and is measured until it is decided.
Table run_until_decided(const Task& task, const UntilDecided& bound);

/// What a way of measuring costs and how it decides, over a mix: seven of ten blades well inside, one and a half well
/// outside, one and a half near a limit.
struct Cost {
    std::string way;
    std::size_t sections = 0, undecided = 0, wrong = 0, points = 0, early = 0, again = 0;
    double seconds = 0.0;
};
std::vector<Cost> compare_costs(std::uint64_t first_seed, std::uint64_t blades, double sigma_mm);

}  // namespace cmm::acquisition::decisions
