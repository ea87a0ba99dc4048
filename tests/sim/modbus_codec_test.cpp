// SPDX-License-Identifier: Apache-2.0
#include "sim/modbus_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace cmm::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Parse = mbap::Parse;

/// 200 registers that hold their own address; register 150 is busy, 160 refuses values.
class Memory final : public RegisterDevice {
  public:
    Memory() {
        for (std::size_t i = 0; i < 200; ++i)
            registers.push_back(static_cast<std::uint16_t>(i));
    }
    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override {
        if (address + to.size() > registers.size()) return ModbusException::illegal_address;
        std::copy_n(registers.begin() + static_cast<std::ptrdiff_t>(address), to.size(), to.begin());
        return ModbusException::none;
    }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        if (address + from.size() > registers.size()) return ModbusException::illegal_address;
        if (address == 150) return ModbusException::busy;
        if (address == 160) return ModbusException::illegal_value;
        std::copy(from.begin(), from.end(), registers.begin() + static_cast<std::ptrdiff_t>(address));
        ++writes;
        return ModbusException::none;
    }
    std::vector<std::uint16_t> registers;
    int writes = 0;
};

Bytes ask(Memory& memory, const Bytes& request) {
    Bytes reply;
    answer_pdu(memory, request, reply);
    return reply;
}

TEST(ModbusCodec, ReadsHoldingRegisters) {
    Memory memory;
    EXPECT_EQ(ask(memory, {3, 0, 10, 0, 3}), (Bytes{3, 6, 0, 10, 0, 11, 0, 12}));
    EXPECT_EQ(ask(memory, {4, 0, 10, 0, 1}), (Bytes{4, 2, 0, 10}));
    EXPECT_EQ(ask(memory, {3, 0, 0, 0, 125}).size(), 252U);
}

TEST(ModbusCodec, WritesOneAndMany) {
    Memory memory;
    EXPECT_EQ(ask(memory, {6, 0, 20, 0x12, 0x34}), (Bytes{6, 0, 20, 0x12, 0x34}));
    EXPECT_EQ(memory.registers[20], 0x1234);
    EXPECT_EQ(ask(memory, {16, 0, 30, 0, 2, 4, 0xAB, 0xCD, 0, 1}), (Bytes{16, 0, 30, 0, 2}));
    EXPECT_EQ(memory.registers[30], 0xABCD);
    EXPECT_EQ(memory.registers[31], 1);
}

TEST(ModbusCodec, ReadWriteWritesFirst) {
    Memory memory;
    EXPECT_EQ(ask(memory, {23, 0, 40, 0, 2, 0, 41, 0, 1, 2, 0x55, 0xAA}), (Bytes{23, 4, 0, 40, 0x55, 0xAA}));
}

TEST(ModbusCodec, ExceptionsSayWhatIsWrong) {
    Memory memory;
    EXPECT_EQ(ask(memory, {1, 0, 0, 0, 1}), (Bytes{0x81, 1}));
    EXPECT_EQ(ask(memory, {43, 14, 1, 0}), (Bytes{0xAB, 1}));
    EXPECT_EQ(ask(memory, {3, 0, 199, 0, 2}), (Bytes{0x83, 2}));
    EXPECT_EQ(ask(memory, {3, 0xFF, 0xFF, 0, 2}), (Bytes{0x83, 2}));
    EXPECT_EQ(ask(memory, {3, 0, 0, 0, 0}), (Bytes{0x83, 3}));
    EXPECT_EQ(ask(memory, {3, 0, 0, 0, 126}), (Bytes{0x83, 3}));
    EXPECT_EQ(ask(memory, {6, 0, 200, 0, 0}), (Bytes{0x86, 2}));
    EXPECT_EQ(ask(memory, {6, 0, 150, 0, 0}), (Bytes{0x86, 6}));
    EXPECT_EQ(ask(memory, {16, 0, 160, 0, 1, 2, 0, 0}), (Bytes{0x90, 3}));
    EXPECT_EQ(ask(memory, {23, 0, 190, 0, 20, 0, 1, 0, 1, 2, 0, 9}), (Bytes{0x97, 2}));
}

TEST(ModbusCodec, LengthsThatDoNotFitChangeNothing) {
    Memory memory;
    const std::vector<Bytes> broken{
        {3},
        {3, 0, 0, 0},
        {3, 0, 0, 0, 1, 0},
        {6, 0, 0, 0},
        {16, 0, 0},
        {16, 0, 0, 0, 2, 4, 0, 0, 0},
        {16, 0, 0, 0, 2, 3, 0, 0, 0, 0},
        {16, 0, 0, 0, 0, 0},
        {16, 0, 0, 0, 1, 2, 0, 0, 0},
        {23, 0, 0, 0, 1, 0, 0, 0, 1},
        {23, 0, 0, 0, 0, 0, 0, 0, 1, 2, 0, 0},
        {23, 0, 0, 0, 126, 0, 0, 0, 1, 2, 0, 0},
        {23, 0, 0, 0, 1, 0, 0, 0, 2, 2, 0, 0},
    };
    for (const Bytes& request : broken) {
        const Bytes reply = ask(memory, request);
        EXPECT_EQ(reply, (Bytes{static_cast<std::uint8_t>(request[0] | 0x80U), 3})) << "size " << request.size();
    }
    Bytes much(6 + 2 * 124, 0);
    much[0] = 16;
    much[4] = 124;
    much[5] = 248;
    EXPECT_EQ(ask(memory, much), (Bytes{0x90, 3}));
    EXPECT_EQ(memory.writes, 0);
}

TEST(ModbusCodec, FramesAreCutFromTheStream) {
    const Bytes stream{0, 1, 0, 0, 0, 6, 1, 3, 0, 10, 0, 1, 0, 2, 0, 0, 0, 6, 9, 3, 0, 11, 0, 1};
    mbap::Frame frame;
    for (std::size_t size = 0; size < 12; ++size)
        EXPECT_EQ(mbap::next_frame(std::span(stream).first(size), frame), Parse::partial) << size;
    ASSERT_EQ(mbap::next_frame(stream, frame), Parse::complete);
    EXPECT_EQ(frame.size, 12U);
    EXPECT_EQ(frame.pdu.size(), 5U);
    ASSERT_EQ(mbap::next_frame(std::span(stream).subspan(12), frame), Parse::complete);
    Memory memory;
    Bytes reply;
    answer_frame(memory, frame, reply);
    EXPECT_EQ(reply, (Bytes{0, 2, 0, 0, 0, 5, 9, 3, 2, 0, 11}));
}

TEST(ModbusCodec, BrokenHeadersAreMalformed) {
    mbap::Frame frame;
    EXPECT_EQ(mbap::next_frame(Bytes{0, 1, 0, 7}, frame), Parse::malformed) << "another protocol";
    EXPECT_EQ(mbap::next_frame(Bytes{0, 1, 0, 0, 0, 1, 1}, frame), Parse::malformed) << "no function code";
    EXPECT_EQ(mbap::next_frame(Bytes{0, 1, 0, 0, 0, 0, 1}, frame), Parse::malformed);
    EXPECT_EQ(mbap::next_frame(Bytes{0, 1, 0, 0, 0, 255, 1}, frame), Parse::malformed) << "longer than a PDU can be";
    EXPECT_EQ(mbap::next_frame(Bytes{0, 1, 0, 0, 0, 254, 1}, frame), Parse::partial);
}

}  // namespace
}  // namespace cmm::sim
