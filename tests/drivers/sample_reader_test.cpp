// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/sample_reader.hpp"

#include <gtest/gtest.h>

#include "drivers/modbus/blocks.hpp"

namespace cmm::drivers::modbus {
namespace {

using controller::SampleReader;

std::vector<core::Sample> decoded;  // of the last block: the reader hands out a part of it

/// A sample block with the given numbers, x counts = number.
struct Block {
    Block(std::uint32_t first, std::uint16_t count, std::uint32_t newest, std::uint16_t flags = 0) {
        map.put_u32(registers, map.fifo.first_seq, first);
        map.put_u32(registers, map.fifo.newest_seq, newest);
        registers[map.fifo.count] = count;
        registers[map.fifo.flags.at] = flags;
        registers[map.fifo.path] = 4;
        registers[map.fifo.time_us + 2U] = 500;
        for (std::uint16_t k = 0; k < count; ++k) {
            const std::size_t at = map.fifo.points + std::size_t{k} * map.fifo.point_length;
            map.put_i32(registers, at, static_cast<std::int32_t>(first + k));
            map.put_i32(registers, at + 2, -7);
            registers[at + 6] = 25;
            registers[at + 7] = (9U << 8U) | 1U;
        }
        registers[map.fifo.crc] = crc16(
            std::span(registers).first(map.fifo.points + std::size_t{count} * map.fifo.point_length), map.fifo.crc);
    }
    core::Result<std::span<const core::Sample>> into(SampleReader& reader,
                                                     SampleReader::Asked asked = SampleReader::Asked::due) {
        EXPECT_TRUE(check_fifo(map, registers));
        const FifoBlock block = decode_fifo(map, registers);
        decode_samples(map, registers, block, decoded);
        return reader.take(block, decoded, 42, asked);
    }
    RegisterMap map;
    std::array<std::uint16_t, max_read> registers{};
};

TEST(SampleReader, DecodesEveryField) {
    SampleReader reader;
    reader.begin({}, 0);
    const auto samples = Block(1, 2, 2).into(reader);
    ASSERT_TRUE(samples);
    ASSERT_EQ(samples->size(), 2U);
    const core::Sample& second = (*samples)[1];
    EXPECT_EQ(second.sequence, 2U);
    EXPECT_EQ(second.machine_time_us, 750);
    EXPECT_EQ(second.host_time_ns, 42);
    EXPECT_EQ(second.counts, (std::array<std::int32_t, 3>{2, -7, 0}));
    EXPECT_EQ(second.path, 4U);
    EXPECT_EQ(second.flags, core::sample_flag::no_contact);
    EXPECT_EQ(second.deflection_counts, 9);
}

TEST(SampleReader, DropsWhatItHasAndTakesTheRest) {
    SampleReader reader;
    reader.begin({}, 0);
    ASSERT_TRUE(Block(1, 5, 9).into(reader));
    EXPECT_EQ(reader.next_wanted(), 6U);
    const auto again = Block(1, 5, 9).into(reader);
    ASSERT_TRUE(again);
    EXPECT_TRUE(again->empty());
    const auto overlap = Block(4, 6, 9).into(reader);
    ASSERT_TRUE(overlap);
    ASSERT_EQ(overlap->size(), 4U);
    EXPECT_EQ(overlap->front().sequence, 6U);
    EXPECT_EQ(reader.duplicates(), 7U);
    EXPECT_EQ(reader.last_delivered(), 9U);
}

TEST(SampleReader, AGapIsAnErrorThatNamesTheSamples) {
    SampleReader reader;
    reader.begin({}, 0);
    ASSERT_TRUE(Block(1, 3, 20).into(reader));
    const auto gap = Block(7, 3, 20).into(reader);
    ASSERT_FALSE(gap);
    EXPECT_EQ(gap.error().code, core::ErrorCode::protocol_invalid);
    EXPECT_NE(gap.error().message.find("samples 4 to 6 are missing"), std::string::npos) << gap.error().message;
    const auto overflow = Block(7, 3, 20, 1).into(reader);
    ASSERT_FALSE(overflow);
    EXPECT_EQ(overflow.error().code, core::ErrorCode::machine_overflow);
    EXPECT_EQ(reader.next_wanted(), 4U) << "nothing was taken";
}

TEST(SampleReader, ABlockAskedForAheadFollowsOnOrIsDropped) {
    constexpr auto ahead = SampleReader::Asked::ahead;
    SampleReader reader;
    reader.begin({}, 0);
    ASSERT_TRUE(Block(1, 3, 3).into(reader));
    // More came between the two answers, or the block between them is missing.
    auto taken = Block(6, 2, 7).into(reader, ahead);
    ASSERT_TRUE(taken);
    EXPECT_TRUE(taken->empty());
    EXPECT_EQ(reader.next_wanted(), 4U);
    // Answered before the block in front of it was repeated.
    taken = Block(2, 0, 1).into(reader, ahead);
    ASSERT_TRUE(taken);
    EXPECT_TRUE(taken->empty());
    taken = Block(3, 3, 5).into(reader, ahead);
    ASSERT_TRUE(taken);
    EXPECT_EQ(taken->size(), 2U);
    EXPECT_EQ(reader.next_wanted(), 6U);
    EXPECT_EQ(reader.duplicates(), 1U);
}

TEST(SampleReader, NumbersThatGoBackAreAnError) {
    SampleReader reader;
    reader.begin({}, 0);
    ASSERT_TRUE(Block(1, 3, 3).into(reader));
    EXPECT_FALSE(Block(1, 0, 2).into(reader));
    EXPECT_TRUE(Block(4, 0, 3).into(reader));
}

TEST(SampleReader, RunsAreNumberedFromOneWhateverTheControllerCounts) {
    SampleReader reader;
    reader.begin({.boot_id = 1, .sequence_shift = -100, .last_sequence = 0}, 100);
    EXPECT_EQ(reader.next_wanted(), 101U);
    const auto samples = Block(101, 3, 103).into(reader);
    ASSERT_TRUE(samples);
    EXPECT_EQ(samples->front().sequence, 1U);
    EXPECT_EQ(reader.acknowledge(), 100U);
    reader.durable(2);
    EXPECT_EQ(reader.acknowledge(), 102U);
    reader.durable(99);
    EXPECT_EQ(reader.acknowledge(), 103U) << "never more than was delivered";
    reader.durable(1);
    EXPECT_EQ(reader.acknowledge(), 103U) << "never back";
}

TEST(SampleReader, ABlockThatClaimsTooMuchOrIsDamagedFailsItsCheck) {
    Block block(1, 3, 3);
    block.registers[block.map.fifo.points] ^= 1U;
    EXPECT_FALSE(check_fifo(block.map, block.registers));
    Block huge(1, 0, 0);
    huge.registers[huge.map.fifo.count] = 15;
    EXPECT_FALSE(check_fifo(huge.map, huge.registers));
}

}  // namespace
}  // namespace cmm::drivers::modbus
