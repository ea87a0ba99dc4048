// SPDX-License-Identifier: Apache-2.0
#include "cell/handshake.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace cmm::cell {
namespace {

using S = CellState;
using I = CellInput;
using A = CellAction;

std::vector<S> states() {
    std::vector<S> all;
    for (int i = 0; i < cell_state_count; ++i)
        all.push_back(static_cast<S>(i));
    return all;
}

std::vector<I> inputs() {
    std::vector<I> all;
    for (int i = 0; i < cell_input_count; ++i)
        all.push_back(static_cast<I>(i));
    return all;
}

TEST(Handshake, IsTotalAndAnInputOutOfTurnChangesNothing) {
    for (const auto state : states()) {
        for (const auto input : inputs()) {
            const auto next = step(state, input);
            if (next.accepted) continue;
            EXPECT_EQ(next.state, state) << to_string(state);
            EXPECT_EQ(next.action, A::none) << to_string(state);
        }
    }
}

TEST(Handshake, OnePart) {
    const std::vector<std::pair<I, A>> course{{I::neutral, A::none},  {I::start, A::record_start},
                                              {I::recorded, A::run},  {I::ended, A::record_result},
                                              {I::recorded, A::none}, {I::acknowledged, A::record_cleared},
                                              {I::recorded, A::none}};
    S state = S::waiting;
    for (const auto& [input, action] : course) {
        const auto next = step(state, input);
        ASSERT_TRUE(next.accepted) << to_string(state);
        EXPECT_EQ(next.action, action) << to_string(state);
        state = next.state;
    }
    EXPECT_EQ(state, S::waiting);
}

TEST(Handshake, TheMachineRunsOnlyBehindARecordedStart) {
    for (const auto state : states())
        for (const auto input : inputs())
            if (step(state, input).action == A::run) {
                EXPECT_EQ(state, S::starting);
                EXPECT_EQ(input, I::recorded);
            }
}

TEST(Handshake, OnlyTheEndOfTheRunLeavesWhatMayMove) {
    // Whatever else comes, while the machine may move the cell stays with it.
    for (const auto state : {S::busy, S::stopping})
        for (const auto input : inputs()) {
            const S next = step(state, input).state;
            EXPECT_TRUE(next == S::busy || next == S::stopping || input == I::ended) << to_string(state);
        }
    EXPECT_EQ(step(S::busy, I::stop).action, A::stop_run);
}

TEST(Handshake, EveryStartEndsInOneAcknowledgedResult) {
    // From a start the only way back to the next one leads through done and its acknowledgement.
    std::set<S> reached{S::starting, S::recording};
    for (bool grown = true; grown;) {
        grown = false;
        for (const auto state : std::set<S>(reached)) {
            if (state == S::done) continue;
            for (const auto input : inputs())
                grown = reached.insert(step(state, input).state).second || grown;
        }
    }
    EXPECT_FALSE(reached.contains(S::ready));
    EXPECT_FALSE(reached.contains(S::waiting));
    EXPECT_TRUE(reached.contains(S::done));
    for (const auto input : inputs())
        EXPECT_EQ(step(S::done, input).accepted, input == I::acknowledged);
}

}  // namespace
}  // namespace cmm::cell
