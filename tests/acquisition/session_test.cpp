// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session.hpp"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace cmm::acquisition {
namespace {

using S = SessionState;
using I = SessionInput;
using A = SessionAction;

std::vector<S> states() {
    std::vector<S> all;
    for (int i = 0; i < session_state_count; ++i)
        all.push_back(static_cast<S>(i));
    return all;
}

std::vector<I> inputs() {
    std::vector<I> all;
    for (int i = 0; i < session_input_count; ++i)
        all.push_back(static_cast<I>(i));
    return all;
}

TEST(Session, IsTotal) {
    for (const auto state : states()) {
        for (const auto input : inputs()) {
            const auto result = step(state, input);
            if (!result.accepted) {
                EXPECT_EQ(result.state, state) << to_string(state) << " " << to_string(input);
                EXPECT_EQ(result.action, A::none) << to_string(state) << " " << to_string(input);
            } else {
                EXPECT_NE(result.action, A::none) << to_string(state) << " " << to_string(input);
            }
        }
    }
}

TEST(Session, TheGoodCourse) {
    const std::vector<std::pair<I, A>> course{
        {I::start, A::connect},   {I::succeeded, A::recover},  {I::succeeded, A::home},     {I::succeeded, A::qualify},
        {I::succeeded, A::align}, {I::succeeded, A::approach}, {I::succeeded, A::scan},     {I::succeeded, A::approach},
        {I::succeeded, A::scan},  {I::succeeded, A::approach}, {I::no_path_left, A::flush}, {I::succeeded, A::report}};
    S state = S::idle;
    for (const auto& [input, action] : course) {
        const auto result = step(state, input);
        ASSERT_TRUE(result.accepted) << to_string(state);
        EXPECT_EQ(result.action, action) << to_string(state);
        state = result.state;
    }
    EXPECT_EQ(state, S::ended);
}

TEST(Session, AFailureOrAStopInAnyMovingStateStopsTheMachineFirst) {
    for (const auto state : states()) {
        if (!may_move(state) || state == S::stopping) continue;
        for (const auto input : {I::failed, I::stop_requested}) {
            EXPECT_EQ(step(state, input).action, A::stop_machine) << to_string(state);
            EXPECT_EQ(step(state, input).state, S::stopping) << to_string(state);
        }
    }
}

TEST(Session, EveryEndPassesThroughTheFlush) {
    // From every active state, whatever comes, the run can only end by flushing: walk all inputs to exhaustion.
    std::set<S> before_end;
    for (const auto state : states()) {
        for (const auto input : inputs()) {
            if (step(state, input).accepted && step(state, input).state == S::ended) before_end.insert(state);
        }
    }
    EXPECT_EQ(before_end, (std::set<S>{S::idle, S::flushing}));
}

TEST(Session, NothingLeavesTheEnd) {
    for (const auto input : inputs())
        EXPECT_FALSE(step(S::ended, input).accepted) << to_string(input);
}

}  // namespace
}  // namespace cmm::acquisition
