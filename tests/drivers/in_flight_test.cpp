// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/in_flight.hpp"

#include <gtest/gtest.h>

namespace cmm::drivers::modbus {
namespace {

TEST(InFlight, AllThatTheUserAllowsWhileBatchesAreAnswered) {
    InFlight limit(32);
    for (int k = 0; k < 100; ++k) {
        EXPECT_EQ(limit.allowed(), 32U);
        EXPECT_FALSE(limit.judge(32, 32, true, 0.05));
    }
    EXPECT_EQ(InFlight(1).allowed(), 1U);
    EXPECT_EQ(InFlight(2).allowed(), 2U);
}

TEST(InFlight, OneAtATimeAfterTheSecondBatchHalfAnswered) {
    InFlight limit(32);
    EXPECT_FALSE(limit.judge(20, 1, true, 0.0));
    EXPECT_EQ(limit.allowed(), 32U);
    EXPECT_FALSE(limit.judge(3, 3, true, 0.0));
    EXPECT_TRUE(limit.judge(20, 1, true, 0.0)) << "small batches answered in between are no excuse";
    EXPECT_EQ(limit.allowed(), 1U);
    limit.begin_anew();
    EXPECT_EQ(limit.allowed(), 32U);
}

TEST(InFlight, ALinkThatBreaksNowAndThenIsNoReason) {
    InFlight limit(8);
    for (int k = 0; k < 20; ++k) {
        EXPECT_FALSE(limit.judge(8, 3, false, 0.0));
        EXPECT_FALSE(limit.judge(8, 8, true, 0.0));
    }
    EXPECT_EQ(limit.allowed(), 8U);
    EXPECT_FALSE(limit.judge(8, 0, true, 0.0));
    EXPECT_TRUE(limit.judge(8, 3, false, 0.0)) << "twice in a row: whoever is there closes on what comes together";
    EXPECT_EQ(limit.allowed(), 1U);
}

TEST(InFlight, FewerForASlowControllerBecauseAStopWaitsBehindThem) {
    InFlight limit(32);
    for (int k = 0; k < 20; ++k)
        limit.judge(limit.allowed(), limit.allowed(), true, 5.0);
    EXPECT_EQ(limit.allowed(), 4U);
    for (int k = 0; k < 20; ++k)
        limit.judge(limit.allowed(), limit.allowed(), true, 50.0);
    EXPECT_EQ(limit.allowed(), InFlight::fewest);
    for (int k = 0; k < 40; ++k)
        limit.judge(limit.allowed(), limit.allowed(), true, 0.1);
    EXPECT_EQ(limit.allowed(), 32U);
}

}  // namespace
}  // namespace cmm::drivers::modbus
