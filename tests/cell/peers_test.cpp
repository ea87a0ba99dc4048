// SPDX-License-Identifier: Apache-2.0
#include "cell/peers.hpp"

#include <gtest/gtest.h>

namespace cmm::cell {
namespace {

bool allows(const std::string& list, const std::string& peer) {
    Peers peers;
    EXPECT_TRUE(peers.add(list)) << list;
    return peers.contain(boost::asio::ip::make_address(peer));
}

TEST(Peers, SingleAddressesAndNetworks) {
    EXPECT_TRUE(allows("192.168.0.17", "192.168.0.17"));
    EXPECT_FALSE(allows("192.168.0.17", "192.168.0.18"));
    EXPECT_TRUE(allows("10.1.0.0/16", "10.1.255.3"));
    EXPECT_FALSE(allows("10.1.0.0/16", "10.2.0.1"));
    EXPECT_TRUE(allows("10.1.2.128/25", "10.1.2.200"));
    EXPECT_FALSE(allows("10.1.2.128/25", "10.1.2.100"));
    EXPECT_TRUE(allows("0.0.0.0/0", "1.2.3.4"));
    EXPECT_FALSE(allows("0.0.0.0/0", "fd00::1")) << "of the other family nothing was said";
    EXPECT_TRUE(allows("fd00::/8", "fd12::1"));
    EXPECT_FALSE(allows("fd00::/8", "fe80::1"));
}

TEST(Peers, AnAddressOfVersion4IsTheSameOverVersion6) {
    EXPECT_TRUE(allows("192.168.0.17", "::ffff:192.168.0.17"));
    EXPECT_TRUE(allows("::ffff:192.168.0.17", "192.168.0.17"));
}

TEST(Peers, WhatIsNoAddressIsRefused) {
    for (const char* text : {"", "plc7", "10.1.0.0/33", "10.1.0.0/", "10.1.0.0/x", "10.1/16", "fd00::/129", "/8"}) {
        Peers peers;
        const auto added = peers.add(text);
        ASSERT_FALSE(added) << text;
        EXPECT_EQ(added.error().code, core::ErrorCode::usage);
        EXPECT_TRUE(peers.empty());
    }
}

}  // namespace
}  // namespace cmm::cell
