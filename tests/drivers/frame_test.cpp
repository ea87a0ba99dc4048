// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/frame.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cmm::drivers::modbus {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Outcome = Transaction::Outcome;

Bytes encoded(const Transaction& request) {
    std::array<std::uint8_t, max_pdu> pdu{};
    std::array<std::uint8_t, max_frame> frame{};
    const std::size_t size = tcp_frame(0x1501, 0xFF, std::span(pdu).first(encode_pdu(request, pdu)), frame);
    return {frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size)};
}

Transaction read_of(std::uint16_t address, std::uint16_t count) {
    Transaction request;
    request.read_address = address;
    request.read_count = count;
    return request;
}

// The examples of the Modbus application protocol, V1.1b3, 6.3, 6.6, 6.12 and 6.17, behind a TCP header.
TEST(Frame, RequestsOfTheSpecification) {
    EXPECT_EQ(encoded(read_of(0x6B, 3)), (Bytes{0x15, 0x01, 0, 0, 0, 6, 0xFF, 3, 0, 0x6B, 0, 3}));

    Transaction single;
    single.kind = Transaction::Kind::write_single;
    single.write_address = 1;
    single.write_count = 1;
    single.written[0] = 3;
    EXPECT_EQ(encoded(single), (Bytes{0x15, 0x01, 0, 0, 0, 6, 0xFF, 6, 0, 1, 0, 3}));

    Transaction several;
    several.kind = Transaction::Kind::write;
    several.write_address = 1;
    several.write_count = 2;
    several.written = {0x000A, 0x0102};
    EXPECT_EQ(encoded(several), (Bytes{0x15, 0x01, 0, 0, 0, 11, 0xFF, 0x10, 0, 1, 0, 2, 4, 0, 0x0A, 1, 2}));

    Transaction both = read_of(3, 6);
    both.kind = Transaction::Kind::exchange;
    both.write_address = 0x0E;
    both.write_count = 3;
    both.written = {0xFF, 0xFF, 0xFF};
    EXPECT_EQ(encoded(both),
              (Bytes{0x15, 0x01, 0, 0, 0, 17, 0xFF, 0x17, 0, 3, 0, 6, 0, 0x0E, 0, 3, 6, 0, 0xFF, 0, 0xFF, 0, 0xFF}));
}

TEST(Frame, RepliesAreTakenOrJudged) {
    Transaction request = read_of(0x6B, 3);
    const Bytes good{0x15, 0x01, 0, 0, 0, 9, 0xFF, 3, 6, 0x02, 0x2B, 0, 0, 0, 0x64};
    ASSERT_EQ(cut_tcp(good).size, good.size());
    EXPECT_EQ(tcp_id(good), 0x1501);
    take_reply(tcp_pdu(good), request);
    EXPECT_EQ(reply_size(request), 8U);
    EXPECT_EQ(request.outcome, Outcome::ok);
    EXPECT_EQ(request.read[0], 0x022B);
    EXPECT_EQ(request.read[2], 0x64);

    take_reply(tcp_pdu(Bytes{0x15, 0x01, 0, 0, 0, 3, 0xFF, 0x83, 2}), request);
    EXPECT_EQ(request.outcome, Outcome::exception);
    EXPECT_EQ(request.exception, 2);

    // Another count, another function, another echo.
    take_reply(tcp_pdu(Bytes{0x15, 0x01, 0, 0, 0, 7, 0xFF, 3, 4, 0, 1, 0, 2}), request);
    EXPECT_EQ(request.outcome, Outcome::invalid);
    take_reply(tcp_pdu(Bytes{0x15, 0x01, 0, 0, 0, 9, 0xFF, 4, 6, 0, 1, 0, 2, 0, 3}), request);
    EXPECT_EQ(request.outcome, Outcome::invalid);

    Transaction write;
    write.kind = Transaction::Kind::write;
    write.write_address = 256;
    write.write_count = 7;
    take_reply(tcp_pdu(Bytes{0, 0, 0, 0, 0, 6, 1, 16, 1, 0, 0, 7}), write);
    EXPECT_EQ(write.outcome, Outcome::ok);
    take_reply(tcp_pdu(Bytes{0, 0, 0, 0, 0, 6, 1, 16, 1, 0, 0, 8}), write);
    EXPECT_EQ(write.outcome, Outcome::invalid);
}

TEST(Frame, RepliesThatComeTogetherAreCutApart) {
    const Bytes one{0, 1, 0, 0, 0, 3, 1, 0x83, 2};
    Bytes both = one;
    both.insert(both.end(), {0, 2, 0, 0, 0, 4, 1, 0x17, 2, 7});
    EXPECT_EQ(cut_tcp(both).kind, TcpCut::Kind::frame);
    EXPECT_EQ(cut_tcp(both).size, one.size());
    const auto rest = std::span<const std::uint8_t>(both).subspan(one.size());
    EXPECT_EQ(cut_tcp(rest).size, 10U);
    for (std::size_t k = 0; k < rest.size(); ++k)
        EXPECT_EQ(cut_tcp(rest.first(k)).kind, TcpCut::Kind::part) << k;
}

TEST(Frame, AHeaderThatCannotBeIsOutOfStep) {
    const auto kind = [](const Bytes& bytes) { return cut_tcp(bytes).kind; };
    EXPECT_EQ(kind({0, 1, 0, 9}), TcpCut::Kind::garbled);                      // not protocol 0
    EXPECT_EQ(kind({0, 1, 0, 0, 0, 2, 1, 3}), TcpCut::Kind::garbled);          // too short
    EXPECT_EQ(kind({0, 1, 0, 0, 0, 255, 1, 0x83, 2}), TcpCut::Kind::garbled);  // longer than a PDU may be
    EXPECT_EQ(kind({0, 1, 0, 0, 0, 254, 1, 0x83, 2}), TcpCut::Kind::part);
}

}  // namespace
}  // namespace cmm::drivers::modbus
