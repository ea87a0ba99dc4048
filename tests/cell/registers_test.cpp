// SPDX-License-Identifier: Apache-2.0
#include "cell/registers.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "cell/outcome.hpp"

namespace cmm::cell {
namespace {

using Words = std::vector<std::uint16_t>;

ModbusException write(PlcBlock& plc, std::size_t address, const Words& words) {
    return write_registers(plc, address, words);
}

TEST(CellRegisters, TheMapIsTheDocuments) {
    // docs/cell.md, "Registers": addresses are for ever.
    EXPECT_EQ(int{PlcBlock::count}, 20);
    EXPECT_EQ(int{CellBlock::count}, 33);
    const auto at = [](CellBlock::At place) { return CellBlock::first + place; };
    EXPECT_EQ(at(CellBlock::map_version), 102);
    EXPECT_EQ(at(CellBlock::heartbeat), 103);
    EXPECT_EQ(at(CellBlock::status), 104);
    EXPECT_EQ(at(CellBlock::result), 106);
    EXPECT_EQ(at(CellBlock::reason), 107);
    EXPECT_EQ(at(CellBlock::decision), 108);
    EXPECT_EQ(at(CellBlock::run), 110);
    EXPECT_EQ(at(CellBlock::program), 112);
    EXPECT_EQ(at(CellBlock::watchdog_ms), 115);
    EXPECT_EQ(at(CellBlock::plc_heartbeat), 116);
    EXPECT_EQ(at(CellBlock::serial), 117);
}

TEST(CellRegisters, TextHasItsFirstCharacterInTheHighByte) {
    PlcBlock plc;
    EXPECT_EQ(write(plc, 4, {0x4142, 0x4320, 0x2000}), ModbusException::none);
    EXPECT_EQ(plc.serial_text(), "ABC");
    CellBlock cell;
    cell.put_serial("ABC");
    EXPECT_EQ(cell.words[CellBlock::serial], 0x4142);
    EXPECT_EQ(cell.words[CellBlock::serial + 1], 0x4300);
    cell.put_run(0x12345678);
    EXPECT_EQ(cell.words[CellBlock::run], 0x1234);
    EXPECT_EQ(cell.words[CellBlock::run + 1], 0x5678);
}

TEST(CellRegisters, ASerialNumberOf32CharactersIsWhole) {
    const std::string longest = "0123456789ABCDEF0123456789abcdef";
    CellBlock cell;
    cell.put_serial(longest);
    PlcBlock plc;
    const Words words(cell.words.begin() + CellBlock::serial, cell.words.end());
    EXPECT_EQ(write(plc, PlcBlock::serial, words), ModbusException::none);
    EXPECT_EQ(plc.serial_text(), longest);
    EXPECT_TRUE(is_serial(longest));
    EXPECT_FALSE(is_serial("a\"b"));
    EXPECT_FALSE(is_serial("a\\b"));
    EXPECT_FALSE(is_serial("a\nb"));
    EXPECT_FALSE(is_serial("\xE4"));
}

TEST(CellRegisters, WhatTheMapForbidsLeavesEverythingAsItWas) {
    PlcBlock plc;
    ASSERT_EQ(write(plc, 0, {7, command_bit::part_present, 3}), ModbusException::none);
    const auto before = plc.words;
    EXPECT_EQ(write(plc, 0, {8, 16}), ModbusException::illegal_value);
    EXPECT_EQ(write(plc, 1, {1, 3, 1}), ModbusException::illegal_value);
    EXPECT_EQ(write(plc, 100, {1}), ModbusException::illegal_address);
    EXPECT_EQ(write(plc, 106, {1}), ModbusException::illegal_address);
    EXPECT_EQ(write(plc, 19, {0, 0}), ModbusException::illegal_address);
    EXPECT_EQ(write(plc, 65535, {0}), ModbusException::illegal_address);
    EXPECT_EQ(plc.words, before);
}

TEST(CellRegisters, ReadingStaysWithinOneBlock) {
    const PlcBlock plc;
    const CellBlock cell;
    const auto read = [&](std::size_t address, std::size_t count) {
        Words words(count);
        return read_registers(plc, cell, address, words);
    };
    EXPECT_EQ(read(0, 20), ModbusException::none);
    EXPECT_EQ(read(100, 33), ModbusException::none);
    EXPECT_EQ(read(19, 2), ModbusException::illegal_address);
    EXPECT_EQ(read(99, 2), ModbusException::illegal_address);
    EXPECT_EQ(read(132, 2), ModbusException::illegal_address);
    EXPECT_EQ(read(65535, 125), ModbusException::illegal_address);
}

TEST(CellOutcome, EveryErrorHasANumberOfItsOwnAndAText) {
    std::vector<int> seen;
    for (int code = 0; code <= static_cast<int>(core::ErrorCode::internal); ++code) {
        const auto reason = reason_of(static_cast<core::ErrorCode>(code));
        seen.push_back(static_cast<int>(reason));
        EXPECT_FALSE(text_of(reason).empty()) << code;
        // The hundreds are the exit code of the command line; a stop at the host is no fault of the machine.
        const auto error = static_cast<core::ErrorCode>(code);
        if (error == core::ErrorCode::cancelled || error == core::ErrorCode::internal) continue;
        EXPECT_EQ(seen.back() / 100, error == core::ErrorCode::fit_not_evaluable ? 3 : core::exit_code(error)) << code;
    }
    std::sort(seen.begin(), seen.end());
    EXPECT_EQ(std::adjacent_find(seen.begin(), seen.end()), seen.end()) << "two errors with one number";
}

}  // namespace
}  // namespace cmm::cell
