// SPDX-License-Identifier: Apache-2.0
/// How often decisions are wrong of blades exactly at a limit: `cmmlive_decisions once|again|costs [blades] [bad
/// share] [machine]`: judged once, measured until they are decided, and what that costs over a mix of blades. With
/// `machine` (of `once`) each blade is measured by a machine and a probe of its own, drawn from usual figures.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "support/drawn_errors.hpp"
#include "tests/acquisition/decision_trials.hpp"
#include "tests/acquisition/until_decided_trials.hpp"

namespace {

using cmm::acquisition::decisions::Rates;
using cmm::acquisition::decisions::Table;

void print(const std::string& name, const Rates& rates) {
    using cmm::acquisition::decisions::binomial_interval;
    const auto accept = binomial_interval(rates.accepted, rates.trials);
    const auto reject = binomial_interval(rates.rejected, rates.trials);
    const double n = static_cast<double>(std::max<std::size_t>(1, rates.trials));
    const double held =
        rates.intervals > 0 ? static_cast<double>(rates.held) / static_cast<double>(rates.intervals) : 0.0;
    std::printf("%-50s %6.2f [%5.2f %5.2f] %6.2f [%5.2f %5.2f] %6zu %5zu  %7.3f %7.3f %7.3f  %5.1f\n", name.c_str(),
                100.0 * rates.accept_share(), 100.0 * accept.first, 100.0 * accept.second, 100.0 * rates.reject_share(),
                100.0 * reject.first, 100.0 * reject.second, rates.trials, rates.refused, 1e3 * rates.error / n,
                1e3 * std::sqrt(rates.squares / n), 1e3 * rates.guard / n, 100.0 * held);
}

}  // namespace

int costs(std::uint64_t blades) {
    using namespace cmm::acquisition;
    for (const double sigma_mm : {1e-3, 2e-3, 5e-3}) {
        std::printf("noise %.0f um: points and seconds a section, %% undecided, wrong, early, measured again\n",
                    1e3 * sigma_mm);
        for (const auto& cost : decisions::compare_costs(1, blades, sigma_mm)) {
            const double n = static_cast<double>(std::max<std::size_t>(1, cost.sections));
            std::printf("%-30s %7.0f %7.1f %6.2f %6.2f %6.2f %6.2f\n", cost.way.c_str(),
                        static_cast<double>(cost.points) / n, cost.seconds / n,
                        100.0 * static_cast<double>(cost.undecided) / n, 100.0 * static_cast<double>(cost.wrong) / n,
                        100.0 * static_cast<double>(cost.early) / n, 100.0 * static_cast<double>(cost.again) / n);
        }
        std::fflush(stdout);
    }
    return 0;
}

int main(int count, char** arguments) {
    using namespace cmm::acquisition;
    const std::string what = count > 1 ? arguments[1] : "once";
    const auto blades = static_cast<std::uint64_t>(count > 2 ? std::atoll(arguments[2]) : 10000);
    if (what == "costs") return costs(blades);
    const double bad_share = count > 3 ? std::atof(arguments[3]) : 0.0;
    const bool machine = count > 4 && std::string(arguments[4]) == "machine";
    std::uint64_t seed = 1;
    const auto& families = cmm::fitting::families::all_families;
    const std::vector<double> sigmas_mm{1e-3, 2e-3, 5e-3};
    const std::uint64_t cells = families.size() * sigmas_mm.size();
    Table all;
    // Each family and noise has a ninth of the blades, none twice.
    for (std::uint64_t cell = 0; cell < cells; ++cell) {
        decisions::Task task;
        task.family = families[cell % families.size()];
        task.sigmas_mm = {sigmas_mm[cell / families.size()]};
        task.first_seed = seed;
        task.blades = (blades + cells - 1 - cell) / cells;
        task.bad_share = bad_share;
        if (machine) task.errors = cmm::fitting::drawn_errors::usual_errors();
        seed += task.blades;
        const auto table = what == "again" ? decisions::run_until_decided(task, {}) : decisions::run(task).front();
        const std::string noise = std::to_string(std::lround(1e3 * task.sigmas_mm.front())) + " um";
        for (const auto& [name, rates] : table) {
            all[name].add(rates);
            all[name + " [" + noise + "]"].add(rates);
            all[name + " [" + noise + ", " + cmm::fitting::families::to_string(task.family) + "]"].add(rates);
        }
    }
    std::printf(
        "%% falsely accepted [95 %%], %% falsely rejected [95 %%], trials, refused; um or mrad: mean error, rms, "
        "guard band; %% of U95 that hold the limit\n");
    for (const auto& [name, rates] : all)
        print(name, rates);
    return 0;
}
