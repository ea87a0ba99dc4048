// SPDX-License-Identifier: Apache-2.0
#include "sim/modbus_wire.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "sim/serial_line.hpp"

namespace cmm::sim::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// 16 registers that count what is written to them.
class Registers final : public RegisterDevice {
  public:
    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override {
        if (address + to.size() > 16) return ModbusException::illegal_address;
        for (std::size_t k = 0; k < to.size(); ++k)
            to[k] = values[address + k];
        return ModbusException::none;
    }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        for (std::size_t k = 0; k < from.size(); ++k)
            values[address + k] = from[k];
        ++writes;
        return ModbusException::none;
    }
    std::array<std::uint16_t, 16> values{};
    int writes = 0;
};

Bytes with_crc(Bytes frame) {
    const std::uint16_t crc = rtu_crc(frame);
    frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
    return frame;
}

struct Rtu {
    Registers registers;
    RtuProtocol protocol{registers, 1};
    Bytes out;
    std::size_t take(const Bytes& in, core::Duration silent_for = {}) {
        out.clear();
        return protocol.answer(in, silent_for, out).used;
    }
};

TEST(RtuProtocol, TheRequestOfTheTextBooksIsAnswered) {
    Rtu rtu;
    rtu.registers.values[0] = 0x1234;
    EXPECT_EQ(rtu.take({1, 3, 0, 0, 0, 1, 0x84, 0x0A}), 8U);
    EXPECT_EQ(rtu.out, with_crc({1, 3, 2, 0x12, 0x34}));
    EXPECT_EQ(rtu.take(with_crc({1, 3, 0, 99, 0, 1})), 8U);
    EXPECT_EQ(rtu.out, with_crc({1, 0x83, 2}));
    EXPECT_EQ(rtu.take(with_crc({1, 16, 0, 2, 0, 2, 4, 0, 7, 0, 8})), 13U);
    EXPECT_EQ(rtu.out, with_crc({1, 16, 0, 2, 0, 2}));
    EXPECT_EQ(rtu.take(with_crc({1, 23, 0, 2, 0, 1, 0, 3, 0, 1, 2, 0, 9})), 15U);
    EXPECT_EQ(rtu.out, with_crc({1, 23, 2, 0, 7}));
    EXPECT_EQ(rtu.registers.values[3], 9);
}

TEST(RtuProtocol, AWrongCrcIsNotAnsweredAndEndsWithTheSilence) {
    Rtu rtu;
    Bytes frame = with_crc({1, 6, 0, 1, 0, 5});
    frame[5] ^= 0x10;
    EXPECT_EQ(rtu.take(frame), 0U);
    EXPECT_EQ(rtu.take(frame, RtuProtocol::silence), frame.size());
    EXPECT_TRUE(rtu.out.empty());
    EXPECT_EQ(rtu.registers.writes, 0);
    const Bytes half{1, 3, 0};
    EXPECT_EQ(rtu.take(half), 0U);
    EXPECT_EQ(rtu.take(half, RtuProtocol::silence), half.size());
}

TEST(RtuProtocol, OtherUnitsAreNotForUsAndABroadcastIsNotAnswered) {
    Rtu rtu;
    EXPECT_EQ(rtu.take(with_crc({2, 6, 0, 1, 0, 5})), 8U);
    EXPECT_EQ(rtu.registers.writes, 0);
    EXPECT_TRUE(rtu.out.empty());
    EXPECT_EQ(rtu.take(with_crc({0, 6, 0, 1, 0, 5})), 8U);
    EXPECT_EQ(rtu.registers.writes, 1);
    EXPECT_TRUE(rtu.out.empty());
}

TEST(RtuProtocol, AnUnknownFunctionIsAnExceptionOnceItHasEnded) {
    Rtu rtu;
    const Bytes request = with_crc({1, 0x2B, 14, 1, 0});
    EXPECT_EQ(rtu.take(request), 0U);
    EXPECT_EQ(rtu.take(request, RtuProtocol::silence), request.size());
    EXPECT_EQ(rtu.out, with_crc({1, 0xAB, 1}));
}

TEST(OpenLine, APtyIsLinkedWhileItIsOpen) {
    const std::string link = std::filesystem::temp_directory_path() / ("cmmlive-pty-" + std::to_string(::getpid()));
    SerialLine line;
    line.path = link;
    line.pty = true;
    {
        const auto opened = OpenLine::open(line);
        ASSERT_TRUE(opened) << opened.error().text();
        const int host = ::open(link.c_str(), O_RDWR | O_NOCTTY);
        ASSERT_GE(host, 0);
        EXPECT_EQ(::write(opened->fd(), "\x01\n\x11", 3), 3);
        std::array<char, 8> got{};
        EXPECT_EQ(::read(host, got.data(), got.size()), 3) << "raw: no byte means anything to the line";
        EXPECT_EQ(got[1], '\n');
        ::close(host);
        EXPECT_EQ(::read(opened->fd(), got.data(), got.size()), -1) << "a host that leaves does not end the line";
        EXPECT_EQ(errno, EAGAIN);
    }
    EXPECT_FALSE(std::filesystem::is_symlink(link));
}

TEST(OpenLine, WhatCannotBeOpenedSaysWhy) {
    SerialLine line;
    line.path = "/dev/no-such-port";
    const auto missing = OpenLine::open(line);
    ASSERT_FALSE(missing);
    EXPECT_NE(missing.error().text().find("/dev/no-such-port"), std::string::npos);
    line.path = "/dev/null";
    EXPECT_FALSE(OpenLine::open(line)) << "no serial line";
    line.pty = true;
    EXPECT_FALSE(OpenLine::open(line)) << "a file that is there stays there";
    EXPECT_TRUE(std::filesystem::exists("/dev/null"));
}

}  // namespace
}  // namespace cmm::sim::test
