// SPDX-License-Identifier: Apache-2.0
#include "sim/sample_fifo.hpp"

#include <gtest/gtest.h>

namespace cmm::sim {
namespace {

TEST(SampleFifo, NumbersFromOneWithoutGaps) {
    SampleFifo fifo(3);
    EXPECT_EQ(fifo.newest(), 0U);
    EXPECT_FALSE(fifo.holds(0));
    for (std::uint32_t i = 1; i <= 3; ++i)
        EXPECT_EQ(fifo.push({}), i);
    EXPECT_TRUE(fifo.full());
    EXPECT_EQ(fifo.at(2).seq, 2U);
}

TEST(SampleFifo, AcknowledgingFreesAndNeverGoesBack) {
    SampleFifo fifo(3);
    for (int i = 0; i < 3; ++i)
        fifo.push({});
    EXPECT_FALSE(fifo.acknowledge(4)) << "a sample that does not exist";
    EXPECT_EQ(fifo.level(), 3U);
    EXPECT_TRUE(fifo.acknowledge(2));
    EXPECT_TRUE(fifo.acknowledge(1));
    EXPECT_EQ(fifo.acknowledged(), 2U);
    EXPECT_FALSE(fifo.holds(2));
    EXPECT_EQ(fifo.at(3).seq, 3U);
    EXPECT_EQ(fifo.push({}), 4U);
    EXPECT_TRUE(fifo.acknowledge(4));
    EXPECT_EQ(fifo.level(), 0U);
}

}  // namespace
}  // namespace cmm::sim
