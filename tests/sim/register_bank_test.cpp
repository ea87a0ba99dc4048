// SPDX-License-Identifier: Apache-2.0
#include "sim/register_bank.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/registers.hpp"
#include "tests/sim/served_bar.hpp"

namespace cmm::sim::test {
namespace {

using Exception = ModbusException;
using Words = std::vector<std::uint16_t>;

/// The controller of a rig seen through its registers.
struct Bank {
    explicit Bank(ControllerOptions options = bar_options())
        : rig(std::move(options)), bank(rig.controller, repository_map()) {}

    Words read(std::size_t address, std::size_t count) {
        Words registers(count);
        EXPECT_EQ(bank.read(address, registers), Exception::none) << address;
        return registers;
    }
    Exception exchange(std::uint32_t ack, std::uint32_t from) {
        return bank.write(384, Words{++watchdog, high(ack), low(ack), high(from), low(from)});
    }
    Words fifo(std::uint32_t ack, std::uint32_t from) {
        EXPECT_EQ(exchange(ack, from), Exception::none);
        return read(400, 125);
    }
    static std::uint16_t high(std::uint32_t value) { return static_cast<std::uint16_t>(value >> 16U); }
    static std::uint16_t low(std::uint32_t value) { return static_cast<std::uint16_t>(value & 0xFFFFU); }

    Rig rig;
    RegisterBank bank;
    std::uint16_t watchdog = 0;
};

Words command_block(std::uint16_t seq, std::uint16_t code, std::int32_t first = 0) {
    Words block(21);
    block[0] = seq;
    block[1] = code;
    block[3] = 7;
    block[4] = Bank::high(static_cast<std::uint32_t>(first));
    block[5] = Bank::low(static_cast<std::uint32_t>(first));
    block[20] = block_crc(block, 20);
    return block;
}

Words window(std::uint16_t id, std::uint32_t first, const std::vector<PathPoint>& points) {
    Words block(6 + 11 * points.size());
    block[0] = id;
    block[1] = Bank::high(first);
    block[2] = Bank::low(first);
    block[3] = static_cast<std::uint16_t>(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint16_t* to = block.data() + 6 + 11 * i;
        for (int axis = 0; axis < 3; ++axis) {
            const auto counts = static_cast<std::uint32_t>(std::lround(points[i].position[axis] * 1e4));
            to[2 * axis] = Bank::high(counts);
            to[2 * axis + 1] = Bank::low(counts);
            to[6 + axis] = static_cast<std::uint16_t>(std::lround(points[i].normal[axis] * 32767));
        }
        to[9] = static_cast<std::uint16_t>(std::lround(points[i].speed_mm_s * 100));
        to[10] = static_cast<std::uint16_t>((points[i].record ? 1 : 0) | (points[i].last ? 2 : 0));
    }
    block[4] = block_crc(block, 4);
    return block;
}

TEST(RegisterBank, IdentityIsThatOfTheMachine) {
    Bank bank;
    const Words id = bank.read(0, 46);
    EXPECT_EQ(id[0], 0x434D);
    EXPECT_EQ(id[1], 0x4D31);
    EXPECT_EQ(id[2], 1);
    EXPECT_EQ(id[4], 'c' << 8 | 'm');
    EXPECT_EQ(id[20], 100);
    EXPECT_EQ(id[21], 1000);
    EXPECT_EQ(id[22], 8192);
    EXPECT_EQ(id[24], 10);
    EXPECT_EQ(static_cast<std::int32_t>(get32(id, 28, true)), -5000000);
    EXPECT_EQ(static_cast<std::int32_t>(get32(id, 38, true)), 7000000);
    EXPECT_EQ(get32(id, 40, true), 400000U);
    EXPECT_EQ(get32(id, 42, true), 1500000U);
    EXPECT_EQ(id[44], 77);
    EXPECT_EQ(id[45], block_crc(id, 45));
}

TEST(RegisterBank, StatusShowsTheController) {
    Bank bank;
    bank.rig.prepare();
    const Words status = bank.read(64, 37);
    EXPECT_EQ(status[0], 0);
    EXPECT_EQ(status[2], 1 | 2 | 16);
    EXPECT_EQ(status[4], bank.rig.seq);
    EXPECT_EQ(status[5], 2);
    EXPECT_EQ(get32(status, 24, true), 500000U);
    EXPECT_EQ(get32(status, 34, true), 7U);
    EXPECT_EQ(status[36], block_crc(status, 36));
    EXPECT_EQ(bank.read(88, 6), Words(status.begin() + 24, status.begin() + 30)) << "part of a block";
}

TEST(RegisterBank, CommandsNeedACrcAndASequence) {
    Bank bank;
    Words block = command_block(5, 1);
    block[20] ^= 1U;
    EXPECT_EQ(bank.bank.write(128, block), Exception::illegal_value);
    EXPECT_EQ(bank.read(68, 1)[0], 0) << "not taken";
    EXPECT_EQ(bank.bank.write(128, command_block(0, 1)), Exception::illegal_value);
    EXPECT_EQ(bank.bank.write(128, command_block(5, 1)), Exception::none);
    EXPECT_EQ(bank.read(68, 3), (Words{5, 2, 0}));
    EXPECT_EQ(bank.read(128, 21), command_block(5, 1)) << "reads back";
    EXPECT_EQ(bank.bank.write(128, command_block(6, 3)), Exception::none);
    EXPECT_EQ(bank.read(64, 1)[0], 1) << "homing";
    EXPECT_EQ(bank.bank.write(128, Words(20)), Exception::illegal_value);
}

TEST(RegisterBank, AddressesOutsideTheBlocks) {
    Bank bank;
    Words some(2);
    EXPECT_EQ(bank.bank.read(45, some), Exception::illegal_address) << "leaves its block";
    EXPECT_EQ(bank.bank.read(60000, some), Exception::illegal_address);
    EXPECT_EQ(bank.bank.write(0, some), Exception::illegal_address) << "read only";
    EXPECT_EQ(bank.bank.write(64, some), Exception::illegal_address);
    EXPECT_EQ(bank.bank.write(400, some), Exception::illegal_address);
    EXPECT_EQ(bank.bank.write(200, some), Exception::illegal_address);
    EXPECT_EQ(bank.bank.write(386, some), Exception::illegal_value) << "half an exchange";
}

TEST(RegisterBank, StopNeedsNoOwner) {
    Bank bank;
    EXPECT_EQ(bank.bank.write(200, Words{3}), Exception::illegal_value);
    EXPECT_EQ(bank.bank.write(200, Words{1}), Exception::none);
    EXPECT_EQ(bank.read(64, 4), (Words{6, bank.read(65, 1)[0], 0, 13}));
    EXPECT_EQ(bank.bank.write(200, Words{2}), Exception::none);
    EXPECT_EQ(bank.read(64, 1)[0], 8);
}

TEST(RegisterBank, PathWindowsAreChecked) {
    ControllerOptions options = bar_options();
    options.machine.path_capacity = 16;
    Bank bank(options);
    bank.rig.prepare();
    bank.rig.send(opcode::path_begin, {300});
    const auto path = arc_path(30, 0.01, 20.0);
    const std::vector<PathPoint> ten(path.begin(), path.begin() + 10);
    Words good = window(300, 0, ten);
    EXPECT_EQ(good.size(), 116U);
    Words bad = good;
    bad[20] ^= 1U;
    EXPECT_EQ(bank.bank.write(256, bad), Exception::illegal_value);
    EXPECT_EQ(bank.bank.write(256, window(301, 0, ten)), Exception::illegal_value);
    EXPECT_EQ(bank.bank.write(256, Words(good.begin(), good.end() - 1)), Exception::illegal_value);
    EXPECT_EQ(bank.bank.write(257, Words(good.begin() + 1, good.end())), Exception::illegal_value);
    EXPECT_EQ(bank.bank.write(256, good), Exception::none);
    EXPECT_EQ(bank.bank.write(256, good), Exception::none) << "a repetition";
    EXPECT_EQ(bank.bank.write(256, window(300, 11, ten)), Exception::illegal_value) << "a gap";
    EXPECT_EQ(bank.bank.write(256, window(300, 10, ten)), Exception::busy);
    EXPECT_EQ(get32(bank.read(82, 2), 0, true), 10U);
    EXPECT_NEAR(bank.rig.controller.path().at(9).position.y(), path[9].position.y(), 1e-4);
    EXPECT_NEAR((bank.rig.controller.path().at(9).normal - path[9].normal).norm(), 0.0, 1e-4);
    EXPECT_DOUBLE_EQ(bank.rig.controller.path().at(9).speed_mm_s, 20.0);
}

TEST(RegisterBank, LostExchangesLoseAndDoubleNothing) {
    Bank bank;
    bank.rig.prepare();
    bank.rig.scan(9, arc_path(40, 0.01, 20.0));
    const Words first = bank.fifo(0, 0);
    EXPECT_EQ(first[2], 9);
    EXPECT_EQ(get32(first, 3, true), 1U);
    EXPECT_EQ(get32(first, 5, true), 40U);
    EXPECT_EQ(first[7], 14);
    EXPECT_EQ(first[8], 2 | 4);
    EXPECT_EQ(first[12], block_crc(std::span(first).first(13 + 8 * 14), 12));
    const Words again = bank.fifo(0, 0);
    EXPECT_EQ(Words(first.begin() + 13, first.end()), Words(again.begin() + 13, again.end()));
    const Words ahead = bank.fifo(0, 15);
    EXPECT_EQ(get32(ahead, 3, true), 15U) << "reading runs ahead of the acknowledgement";
    const Words rest = bank.fifo(28, 0);
    EXPECT_EQ(get32(rest, 3, true), 29U);
    EXPECT_EQ(rest[7], 12);
    EXPECT_EQ(rest[8], 4) << "nothing waits behind it";
    EXPECT_EQ(get32(bank.fifo(5, 3), 3, true), 29U) << "freed samples are gone; a lower ack changes nothing";
    const Words empty = bank.fifo(40, 0);
    EXPECT_EQ(empty[7], 0);
    EXPECT_EQ(get32(empty, 3, true), 41U);
    EXPECT_EQ(empty[12], block_crc(std::span(empty).first(13), 12));
    EXPECT_EQ(bank.exchange(41, 0), Exception::illegal_value) << "a sample that does not exist yet";
}

TEST(RegisterBank, TimesAddUpToTheSamplesTime) {
    Bank bank;
    bank.rig.prepare();
    bank.rig.scan(1, arc_path(14, 0.0123, 17.0));
    const Words block = bank.fifo(0, 0);
    const auto samples = bank.rig.samples();
    std::int64_t time_us = std::int64_t{block[9]} << 32 | std::int64_t{block[10]} << 16 | block[11];
    ASSERT_EQ(block[7], 14);
    EXPECT_EQ(block[13 + 6], 0);
    for (std::size_t i = 0; i < 14; ++i) {
        time_us += 10 * block[13 + 8 * i + 6];
        EXPECT_LE(std::abs(time_us - samples[i].time_us), 10) << i;
        EXPECT_EQ(static_cast<std::int32_t>(get32(block, 13 + 8 * i, true)), samples[i].counts[0]);
    }
}

TEST(RegisterBank, ABlockEndsBeforeALongPauseAndBeforeAnotherPath) {
    Bank bank;
    bank.rig.prepare();
    const auto path = arc_path(10, 0.01, 20.0);
    bank.rig.send(opcode::path_begin, {1});
    bank.rig.controller.append_path(1, 0, std::span(path).first(4));
    bank.rig.send(opcode::scan, {1, 10000, 10000, 10000});
    bank.rig.run_ms(3000);
    bank.rig.controller.append_path(1, 4, std::span(path).subspan(4));
    bank.rig.finish();
    EXPECT_EQ(bank.fifo(0, 0)[7], 4) << "0.65535 s is all that dt holds";
    EXPECT_EQ(bank.fifo(4, 0)[7], 6);
    bank.rig.finish(opcode::move, {200000, 0, 0, 100000});
    bank.rig.scan(2, arc_path(5, 0.01, 20.0));
    const Words first = bank.fifo(4, 0);
    EXPECT_EQ(first[2], 1);
    EXPECT_EQ(first[7], 6);
    EXPECT_EQ(first[8], 2 | 4);
    const Words second = bank.fifo(10, 0);
    EXPECT_EQ(second[2], 2);
    EXPECT_EQ(second[7], 5);
}

TEST(RegisterBank, AnyExchangeFeedsTheWatchdog) {
    Bank bank;
    bank.rig.prepare();
    bank.rig.send(opcode::move, {500000, 4000000, 0, 100000});
    for (int i = 0; i < 10; ++i) {
        bank.rig.clock.advance(std::chrono::milliseconds(300));
        EXPECT_EQ(bank.bank.write(384, Words{++bank.watchdog}), Exception::none);
        bank.rig.controller.step();
    }
    EXPECT_EQ(bank.rig.controller.state(), MachineState::moving);
}

}  // namespace
}  // namespace cmm::sim::test
