// SPDX-License-Identifier: Apache-2.0
/// The intervals of characteristics hold the truth as often as they say; a small part of what bench/coverage.cpp
/// measures.
#include "support/characteristic_coverage.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cmm::fitting::coverage {
namespace {

void add(const Tallies& more, Tallies& all) {
    for (const auto& [name, tally] : more) {
        Tally& sum = all[name];
        sum.held += tally.held;
        sum.trials += tally.trials;
        sum.refused += tally.refused;
        sum.squares += tally.squares;
    }
}

/// Of all families together.
Tallies tallies_of(const Task& wanted) {
    Tallies all;
    for (const auto family : families::all_families) {
        Task task = wanted;
        task.family = family;
        add(run(task).front(), all);
    }
    return all;
}

/// Of n intervals of 95 %: four standard deviations of the share about 95 %, so that the tests ask for what the bench
/// shows with more blades. `filled`: nor are they wide for safety, the errors fill their standard uncertainties.
void expect_held(const Tallies& all, double filled) {
    EXPECT_EQ(all.count("section"), 0U) << "every section can be fitted";
    for (const auto& [name, tally] : all) {
        const double n = static_cast<double>(tally.trials);
        ASSERT_GT(tally.trials, 10U) << name;
        EXPECT_GT(tally.share(), 0.95 - 4.0 * std::sqrt(0.95 * 0.05 / n)) << name;
        EXPECT_GT(std::sqrt(tally.squares / n), filled) << name;
    }
}

TEST(CharacteristicCoverage, IntervalsOfOneMicrometreHoldTheTruth) {
    Task task;
    task.first_seed = 10001;
    task.blades = 16;
    expect_held(tallies_of(task), 0.6);
}

TEST(CharacteristicCoverage, IntervalsHoldTheTruthOfManyMachines) {
    Task task;
    task.first_seed = 20001;
    task.blades = 16;
    task.sections = 2;
    task.errors.ball_mm = 0.5e-3;
    task.errors.form_mm = 0.5e-3;
    task.errors.constant_mm = 1.0e-3;
    task.errors.per_mm = 4e-6;
    task.errors.expansion = 10e-6;
    expect_held(tallies_of(task), 0.5);
}

/// As the program states them: what the other sections tell is in the uncertainties.
TEST(CharacteristicCoverage, IntervalsOfCompensatedSectionsHoldTheTruth) {
    Tallies between, ends;
    for (const auto family : families::all_families) {
        Task task;
        task.family = family;
        task.first_seed = 30001;
        task.blades = 6;
        const auto found = run_compensated(task);
        add(found.front().between, between);
        add(found.front().ends, ends);
    }
    expect_held(between, 0.3);
    expect_held(ends, 0.35);
}

}  // namespace
}  // namespace cmm::fitting::coverage
