// SPDX-License-Identifier: Apache-2.0
#include "acquisition/replay_pace.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cmm::acquisition {
namespace {

using std::chrono::milliseconds;

/// A sample each 10 ms of machine time, from an hour on.
std::vector<core::Sample> recorded(std::size_t count) {
    std::vector<core::Sample> samples(count);
    for (std::size_t k = 0; k < count; ++k)
        samples[k].machine_time_us = 3'600'000'000 + 10'000 * static_cast<std::int64_t>(k);
    return samples;
}

TEST(ReplayPace, FollowsTheMachinesClockAtAnySpeed) {
    const auto samples = recorded(100);
    core::ManualClock clock;
    clock.advance(milliseconds(777));
    ReplayPace real(1.0, clock);
    ReplayPace tenfold(10.0, clock);
    EXPECT_EQ(real.due(samples), 1U);
    EXPECT_EQ(tenfold.due(samples), 1U);
    clock.advance(milliseconds(35));
    EXPECT_EQ(real.due(samples), 4U);
    EXPECT_EQ(tenfold.due(samples), 36U);
    // What was played is not asked about again.
    EXPECT_EQ(real.due(std::span(samples).subspan(4)), 0U);
    clock.advance(milliseconds(5));
    EXPECT_EQ(real.due(std::span(samples).subspan(4)), 1U);
}

TEST(ReplayPace, AsFastAsTaken) {
    const auto samples = recorded(100);
    const core::ManualClock clock;
    ReplayPace pace(0.0, clock);
    EXPECT_TRUE(pace.at_once());
    EXPECT_EQ(pace.due(samples), 100U);
    EXPECT_EQ(pace.due({}), 0U);
}

TEST(ReplayPace, AClockThatWasSetBackHoldsNothingUp) {
    auto samples = recorded(4);
    samples[2].machine_time_us = samples[3].machine_time_us = 5;  // the controller was restarted
    core::ManualClock clock;
    ReplayPace pace(1.0, clock);
    EXPECT_EQ(pace.due(samples), 1U);
    EXPECT_EQ(pace.due(std::span(samples).subspan(2)), 2U);
}

}  // namespace
}  // namespace cmm::acquisition
