// SPDX-License-Identifier: Apache-2.0
/// The intervals of characteristics hold the truth as often as they say; a small part of what bench/coverage.cpp
/// measures.
#include "support/characteristic_coverage.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cmm::fitting::coverage {
namespace {

/// Of n intervals of 95 %: four standard deviations of the share about 95 %, so that the test asks for what the bench
/// shows with more blades.
TEST(CharacteristicCoverage, IntervalsOfOneMicrometreHoldTheTruth) {
    Tallies all;
    for (const auto family : families::all_families) {
        Task task;
        task.family = family;
        task.first_seed = 10001;
        task.blades = 16;
        const auto tallies = run(task);
        for (const auto& [name, tally] : tallies.front()) {
            Tally& sum = all[name];
            sum.held += tally.held;
            sum.trials += tally.trials;
            sum.refused += tally.refused;
            sum.squares += tally.squares;
        }
    }
    EXPECT_EQ(all.count("section"), 0U) << "every section can be fitted";
    for (const auto& [name, tally] : all) {
        const double n = static_cast<double>(tally.trials);
        ASSERT_GT(tally.trials, 10U) << name;
        EXPECT_GT(tally.share(), 0.95 - 4.0 * std::sqrt(0.95 * 0.05 / n)) << name;
        // Nor are they wide for safety: the errors fill their standard uncertainties.
        EXPECT_GT(std::sqrt(tally.squares / n), 0.6) << name;
    }
}

}  // namespace
}  // namespace cmm::fitting::coverage
