// SPDX-License-Identifier: Apache-2.0
#include "core/clock.hpp"

#include <gtest/gtest.h>

namespace cmm::core {
namespace {

TEST(Clock, SystemClockNeverGoesBackAndKnowsTheCentury) {
    const SystemClock clock;
    auto last = clock.now();
    for (int i = 0; i < 1000; ++i) {
        const auto now = clock.now();
        ASSERT_GE(now, last);
        last = now;
    }
    EXPECT_GT(clock.utc_ns(), 1'600'000'000LL * 1'000'000'000LL);
}

TEST(Clock, ManualClockMovesOnlyByHand) {
    ManualClock clock(5);
    EXPECT_EQ(clock.now().count(), 0);
    clock.advance(std::chrono::milliseconds(2));
    EXPECT_EQ(clock.now().count(), 2'000'000);
    EXPECT_EQ(clock.utc_ns(), 2'000'005);
    EXPECT_DOUBLE_EQ(seconds(clock.now()), 0.002);
}

}  // namespace
}  // namespace cmm::core
