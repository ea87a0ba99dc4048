// SPDX-License-Identifier: Apache-2.0
#include "sim/wire_server.hpp"

#include <gtest/gtest.h>

#include "tests/sim/served_bar.hpp"

namespace cmm::sim::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes read_request(std::uint8_t transaction, std::uint16_t address, std::uint8_t count) {
    return {0,
            transaction,
            0,
            0,
            0,
            6,
            1,
            3,
            static_cast<std::uint8_t>(address >> 8U),
            static_cast<std::uint8_t>(address & 0xFFU),
            0,
            count};
}

TEST(WireServer, AnswersOnTheWire) {
    const ServedBar bar;
    RawClient client(bar.port());
    client.send(read_request(9, 0, 2));
    EXPECT_EQ(client.receive(13), (Bytes{0, 9, 0, 0, 0, 7, 1, 3, 4, 0x43, 0x4D, 0x4D, 0x31}));
}

TEST(WireServer, AnswersPipelinedRequestsInOrder) {
    const ServedBar bar;
    RawClient client(bar.port());
    Bytes all;
    for (std::uint8_t i = 0; i < 50; ++i) {
        const Bytes one = read_request(i, 2, 1);
        all.insert(all.end(), one.begin(), one.end());
    }
    client.send(all);
    for (std::uint8_t i = 0; i < 50; ++i)
        EXPECT_EQ(client.receive(11), (Bytes{0, i, 0, 0, 0, 5, 1, 3, 2, 0, 1}));
}

TEST(WireServer, JoinsRequestsFromSingleBytes) {
    const ServedBar bar;
    RawClient slow(bar.port());
    RawClient other(bar.port());
    for (const std::uint8_t byte : read_request(1, 2, 1)) {
        slow.send({byte});
        other.send(read_request(7, 2, 1));  // the round trip in between has the server see each byte alone
        EXPECT_EQ(other.receive(11).size(), 11U);
    }
    EXPECT_EQ(slow.receive(11), (Bytes{0, 1, 0, 0, 0, 5, 1, 3, 2, 0, 1}));
}

TEST(WireServer, AMalformedFrameClosesItsConnectionOnly) {
    const ServedBar bar;
    RawClient good(bar.port());
    for (const Bytes& broken :
         {Bytes{0, 1, 0, 9, 0, 6, 1, 3}, Bytes{0, 1, 0, 0, 0, 1, 1, 3}, Bytes{0, 1, 0, 0, 9, 9, 1, 3}}) {
        RawClient client(bar.port());
        Bytes bytes = read_request(1, 2, 1);
        bytes.insert(bytes.end(), broken.begin(), broken.end());
        client.send(bytes);
        EXPECT_EQ(client.receive(11).size(), 11U) << "what came before is answered";
        EXPECT_TRUE(client.closed());
    }
    good.send(read_request(3, 2, 1));
    EXPECT_EQ(good.receive(11).size(), 11U);
}

TEST(WireServer, AClientThatDoesNotReadDoesNotGrowTheServer) {
    const ServedBar bar;
    RawClient deaf(bar.port());
    RawClient good(bar.port());
    Bytes all;
    for (int i = 0; i < 2000; ++i) {
        const Bytes one = read_request(static_cast<std::uint8_t>(i & 0xFF), 0, 46);
        all.insert(all.end(), one.begin(), one.end());
    }
    deaf.send(all);
    for (std::uint8_t i = 0; i < 20; ++i) {
        good.send(read_request(i, 2, 1));
        EXPECT_EQ(good.receive(11).size(), 11U);
    }
    EXPECT_EQ(deaf.receive(2000 * 101).size(), 2000U * 101U) << "it gets everything in the end";
}

TEST(WireServer, UsedPortsAndBadAddressesAreErrors) {
    const ServedBar bar;
    const auto server = WireServer::make();
    ASSERT_TRUE(server);
    const auto taken = (*server)->listen("127.0.0.1", bar.port(), {});
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().code, core::ErrorCode::transport_connect);
    EXPECT_NE(taken.error().text().find(std::to_string(bar.port())), std::string::npos);
    EXPECT_FALSE((*server)->listen("nowhere", 0, {}));
}

}  // namespace
}  // namespace cmm::sim::test
