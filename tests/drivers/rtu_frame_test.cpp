// SPDX-License-Identifier: Apache-2.0
#include "drivers/modbus/rtu_frame.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cmm::drivers::modbus {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Kind = RtuCut::Kind;

Bytes framed(std::uint8_t unit, const Bytes& pdu) {
    std::array<std::uint8_t, max_frame> frame{};
    const std::size_t size = rtu_frame(unit, pdu, frame);
    return {frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size)};
}

// The request "read 10 registers from 0 of unit 1" with its CRC, as the text books and every line monitor have it.
TEST(RtuFrame, TheCrcGoesLowByteFirst) {
    EXPECT_EQ(framed(1, {3, 0, 0, 0, 10}), (Bytes{1, 3, 0, 0, 0, 10, 0xC5, 0xCD}));
    EXPECT_EQ(framed(17, {3, 0, 0x6B, 0, 3}), (Bytes{0x11, 3, 0, 0x6B, 0, 3, 0x76, 0x87}));
}

TEST(RtuFrame, RepliesAreCutByTheirLength) {
    for (const Bytes& pdu : {Bytes{3, 2, 0x12, 0x34}, Bytes{6, 0, 200, 0, 1}, Bytes{16, 1, 0, 0, 7}, Bytes{0x97, 6},
                             Bytes{23, 4, 1, 2, 3, 4}}) {
        Bytes bytes = framed(9, pdu);
        const std::size_t size = bytes.size();
        for (std::size_t part = 0; part < size; ++part) {
            EXPECT_EQ(cut_rtu(std::span(bytes).first(part), 9).kind, Kind::partial) << part;
        }
        bytes.push_back(9);  // the next reply begins
        const RtuCut cut = cut_rtu(bytes, 9);
        ASSERT_EQ(cut.kind, Kind::reply);
        EXPECT_EQ(cut.size, size);
        EXPECT_EQ(Bytes(cut.pdu.begin(), cut.pdu.end()), pdu);
        EXPECT_EQ(cut_rtu(bytes, 8).kind, Kind::foreign);
    }
}

TEST(RtuFrame, EveryFlippedBitIsNoticed) {
    const Bytes good = framed(1, {3, 4, 0x12, 0x34, 0x56, 0x78});
    for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
        Bytes bytes = good;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ (1U << bit % 8));
        const Kind kind = cut_rtu(bytes, 1).kind;
        EXPECT_TRUE(kind == Kind::garbled || kind == Kind::partial) << bit;
    }
    EXPECT_EQ(cut_rtu(Bytes{1, 0x2B, 0, 0, 0, 0}, 1).kind, Kind::garbled) << "no function of ours";
    EXPECT_EQ(cut_rtu(Bytes{1, 3, 255}, 1).kind, Kind::garbled) << "longer than any frame";
}

}  // namespace
}  // namespace cmm::drivers::modbus
