// SPDX-License-Identifier: Apache-2.0
#include "web/server/event_feed.hpp"

#include <gtest/gtest.h>

namespace cmm::web {
namespace {

using acquisition::Event;
using acquisition::EventKind;

Event numbered(std::uint64_t seq) {
    return Event{seq, EventKind::sample_batch, 0.0, 0.0, "\"section\":" + std::to_string(seq)};
}
TEST(EventFeed, ReadersAskFromWhereTheyAre) {
    EventFeed feed(10);
    for (std::uint64_t seq = 1; seq <= 6; ++seq)
        feed.push(numbered(seq));
    const auto some = feed.read(3, 2);
    EXPECT_EQ(some.first, 3U);
    ASSERT_EQ(some.lines.size(), 2U);
    EXPECT_NE(some.lines[0]->find("\"seq\":3,"), std::string::npos);
    EXPECT_EQ(feed.read(6, 100).lines.size(), 1U);
    EXPECT_TRUE(feed.read(7, 100).lines.empty());
    EXPECT_EQ(feed.read(7, 100).first, 7U);
    EXPECT_EQ(feed.read(1000, 100).first, 7U) << "from the future: what comes next";
}

TEST(EventFeed, WhatIsNotKeptIsNotHidden) {
    EventFeed feed(4);
    for (std::uint64_t seq = 1; seq <= 10; ++seq)
        feed.push(numbered(seq));
    const auto slice = feed.read(2, 100);
    EXPECT_EQ(slice.first, 7U) << "2 to 6 are gone, and the reader sees it";
    EXPECT_EQ(slice.lines.size(), 4U);
}

TEST(EventFeed, AResumedRunCountsOn) {
    EventFeed feed(4);
    feed.push(numbered(1));
    feed.push(numbered(501));
    const auto slice = feed.read(1, 100);
    EXPECT_EQ(slice.first, 501U);
    EXPECT_EQ(slice.lines.size(), 1U);
}

TEST(EventFeed, TellsOnceUntilSomebodyReads) {
    EventFeed feed(4);
    int told = 0;
    feed.on_news([&] { ++told; });
    feed.push(numbered(1));
    feed.push(numbered(2));
    EXPECT_EQ(told, 1);
    static_cast<void>(feed.read(1, 10));
    feed.push(numbered(3));
    EXPECT_EQ(told, 2);
}

}  // namespace
}  // namespace cmm::web
