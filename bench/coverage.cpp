// SPDX-License-Identifier: Apache-2.0
/// How often the 95 % intervals of a section's characteristics hold the truth: `cmmlive_coverage [blades] [bad share]
/// [machine | compensated]`. With `machine` every blade is measured by a machine and a probe of its own, drawn from
/// usual figures; with `compensated` sections are those of twisted blades, compensated by the surface of all.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/characteristic_coverage.hpp"
#include "support/drawn_errors.hpp"

namespace {

using namespace cmm::fitting;

/// One column for each noise.
void print(const std::vector<coverage::Tallies>& tallies) {
    std::set<std::string> names;
    for (const auto& of_noise : tallies)
        for (const auto& [name, tally] : of_noise)
            names.insert(name);
    for (const auto& name : names) {
        std::printf("%-30s", name.c_str());
        for (const auto& of_noise : tallies) {
            const auto found = of_noise.find(name);
            if (found == of_noise.end()) continue;
            const coverage::Tally& t = found->second;
            const double n = t.trials > 0 ? static_cast<double>(t.trials) : 1.0;
            std::printf("  %5.1f %% [%4.2f; %8.3f %8.3f; mean %8.3f]%4zu", 100.0 * t.share(), std::sqrt(t.squares / n),
                        1e3 * std::sqrt(t.error_squares / n), 1e3 * std::sqrt(t.u_squares / n), 1e3 * t.error / n,
                        t.refused);
        }
        std::printf("\n");
    }
    std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
    const auto blades = static_cast<std::uint64_t>(count > 1 ? std::atoll(arguments[1]) : 2000);
    const double bad_share = count > 2 ? std::atof(arguments[2]) : 0.0;
    const std::string kind = count > 3 ? arguments[3] : "";
    const std::vector<double> sigmas{1e-3, 2e-3, 5e-3};
    for (const auto family : families::all_families) {
        coverage::Task task;
        task.family = family;
        task.blades = blades;
        task.sigmas_mm = sigmas;
        task.bad_share = bad_share;
        if (kind == "machine") task.errors = drawn_errors::usual_errors();
        std::printf(
            "%s, %llu blades: share of 95 %% intervals that hold the truth [rms of error/u; rms error, rms u "
            "(um or urad, 1e-6, um2)] refused\n",
            families::to_string(family).c_str(), static_cast<unsigned long long>(blades));
        if (kind != "compensated") {
            print(coverage::run(task));
            continue;
        }
        std::vector<coverage::Tallies> between, ends;
        for (auto& of_noise : coverage::run_compensated(task)) {
            between.push_back(std::move(of_noise.between));
            ends.push_back(std::move(of_noise.ends));
        }
        print(between);
        std::printf("the lowest and the highest sections\n");
        print(ends);
    }
    return 0;
}
