// SPDX-License-Identifier: Apache-2.0
/// Decisions at a limit are wrong as seldom as they say; a small part of what bench/decisions.cpp measures.
#include <gtest/gtest.h>

#include <cmath>

#include "support/drawn_errors.hpp"
#include "tests/acquisition/decision_trials.hpp"
#include "tests/acquisition/until_decided_trials.hpp"

namespace cmm::acquisition::decisions {
namespace {

constexpr double stated_risk = 0.05;
constexpr double by_luck = 0.05 / 8;

/// The number is small: what the test asks for is that no share's interval lies above the stated risk. Four sizes stand
/// at either limit, and each share has the chance to lie there by luck; all together have 5 % (Bonferroni).
void expect_within_risk(const Table& table) {
    for (const auto& [name, rates] : table) {
        ASSERT_GT(rates.trials, 10U) << name;
        EXPECT_LE(binomial_interval(rates.accepted, rates.trials, by_luck).first, stated_risk) << name;
        EXPECT_LE(binomial_interval(rates.rejected, rates.trials, by_luck).first, stated_risk) << name;
    }
}

/// Of all families together; none is called out while it is measured.
Table judged_once(Task task) {
    Table all;
    for (const auto family : fitting::families::all_families) {
        task.family = family;
        const auto tables = run(task);
        for (const auto& [name, rates] : tables.front())
            all[name].add(rates);
    }
    for (const auto& [name, rates] : all) {
        if (name.starts_with("while measuring")) {
            EXPECT_EQ(rates.rejected, 0U) << name;
        }
    }
    return all;
}

TEST(DecisionRisk, BladesAtTheirLimitsAreSeldomMisjudged) {
    Task task;
    task.first_seed = 20001;
    task.blades = 50;
    task.sigmas_mm = {2e-3};
    expect_within_risk(judged_once(task));
}

/// Every blade by a machine of its own: what it does alike to all points is in the guard bands, also of the watch.
TEST(DecisionRisk, NorWhenTheMachineErrs) {
    Task task;
    task.first_seed = 50001;
    task.blades = 40;
    task.errors = fitting::drawn_errors::usual_errors();
    const auto all = judged_once(task);
    expect_within_risk(all);
    for (const auto& [name, rates] : all) {
        if (rates.intervals > 0) {
            EXPECT_GT(binomial_interval(rates.held, rates.intervals, by_luck).second, 0.95) << name;
        }
    }
}

TEST(DecisionRisk, MeasuringUntilDecidedTakesNoMoreRisk) {
    Table all;
    std::size_t again = 0;
    for (const auto family : fitting::families::all_families) {
        Task task;
        task.family = family;
        task.first_seed = 30001;
        task.blades = 21;
        task.sigmas_mm = {2e-3};
        for (const auto& [name, rates] : run_until_decided(task, {})) {
            if (name.starts_with("measured again"))
                again += rates.accepted + rates.rejected;
            else
                all[name].add(rates);
        }
    }
    EXPECT_GT(again, 5U);
    for (const auto& [name, rates] : all) {
        EXPECT_LE(binomial_interval(rates.accepted, rates.trials).first, stated_risk) << name;
        EXPECT_LE(binomial_interval(rates.rejected, rates.trials).first, stated_risk) << name;
    }
}

/// Clopper and Pearson's interval of 10 of 100 (R: binom.test(10, 100)), and of none and all.
TEST(DecisionRisk, SharesHaveTheirIntervals) {
    const auto [low, high] = binomial_interval(10, 100);
    EXPECT_NEAR(low, 0.04900469, 1e-7);
    EXPECT_NEAR(high, 0.17622260, 1e-7);
    EXPECT_EQ(binomial_interval(0, 50).first, 0.0);
    EXPECT_NEAR(binomial_interval(0, 50).second, 1.0 - std::pow(0.025, 1.0 / 50.0), 1e-9);
    EXPECT_EQ(binomial_interval(50, 50).second, 1.0);
}

}  // namespace
}  // namespace cmm::acquisition::decisions
