// SPDX-License-Identifier: Apache-2.0
#include "sim/registers.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace cmm::sim {
namespace {

TEST(Registers, CrcIsThatOfTheModbusSpecification) {
    // Serial line guide 1.02, 6.2.2: the message 02 07 has the CRC 0x1241 (sent low byte first as 41 12).
    const std::vector<std::uint16_t> registers{0x0207};
    EXPECT_EQ(block_crc(registers, 99), 0x1241);
    // "123456789" is 0x4B37; one register more is left out, so the odd byte is covered by the pair before it.
    const std::vector<std::uint16_t> digits{0x3132, 0x3334, 0x3536, 0x3738};
    const std::vector<std::uint16_t> with_crc{0x3132, 0x3334, 0xFFFF, 0x3536, 0x3738};
    EXPECT_EQ(block_crc(digits, 99), block_crc(with_crc, 2));
    EXPECT_NE(block_crc(digits, 99), block_crc(with_crc, 99));
}

TEST(Registers, WideValuesInBothWordOrders) {
    std::array<std::uint16_t, 6> block{};
    RegisterWriter high_first(block, true);
    high_first.put32(0, 0x12345678);
    high_first.put48(2, 0x0000ABCD00010002ULL);
    EXPECT_EQ(block, (std::array<std::uint16_t, 6>{0x1234, 0x5678, 0xABCD, 0x0001, 0x0002, 0}));
    EXPECT_EQ(get32(block, 0, true), 0x12345678U);
    RegisterWriter low_first(block, false);
    low_first.put32(0, 0x12345678);
    EXPECT_EQ(block[0], 0x5678);
    EXPECT_EQ(get32(block, 0, false), 0x12345678U);
}

TEST(Registers, TextIsPaddedWithZero) {
    std::array<std::uint16_t, 3> block{9, 9, 9};
    RegisterWriter(block, true).put_text(0, 3, "abc");
    EXPECT_EQ(block, (std::array<std::uint16_t, 3>{0x6162, 0x6300, 0}));
}

}  // namespace
}  // namespace cmm::sim
