// SPDX-License-Identifier: Apache-2.0
// Frames written by hand from the Modbus application protocol 1.1b3: its own examples where it has one.
#include "cell/modbus_request.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cmm::cell {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Registers 107...: 555, 0, 100, ... as in the protocol's example of function 3.
class Bank final : public RegisterAccess {
  public:
    Bank() : words(200) {
        words[107] = 555;
        words[109] = 100;
    }
    ModbusException read(std::size_t address, std::span<std::uint16_t> to) override {
        if (address + to.size() > words.size()) return ModbusException::illegal_address;
        std::copy_n(words.begin() + static_cast<std::ptrdiff_t>(address), to.size(), to.begin());
        return ModbusException::none;
    }
    ModbusException write(std::size_t address, std::span<const std::uint16_t> from) override {
        if (address + from.size() > words.size()) return ModbusException::illegal_address;
        ++writes;
        std::copy(from.begin(), from.end(), words.begin() + static_cast<std::ptrdiff_t>(address));
        return ModbusException::none;
    }
    std::vector<std::uint16_t> words;
    int writes = 0;
};

Bytes frame(Bytes pdu, std::uint8_t unit = 1) {
    Bytes whole{0x12, 0x34, 0, 0, 0, static_cast<std::uint8_t>(1 + pdu.size()), unit};
    whole.insert(whole.end(), pdu.begin(), pdu.end());
    return whole;
}

/// The reply's PDU; its header has been looked at.
Bytes answer(Bank& bank, const Bytes& pdu, std::uint8_t unit = 1) {
    std::array<std::uint8_t, longest_adu> reply{};
    const Bytes request = frame(pdu, unit);
    EXPECT_EQ(cut_request(request).kind, RequestCut::Kind::request);
    EXPECT_EQ(cut_request(request).size, request.size());
    const std::size_t size = answer_request(bank, 1, request, reply);
    const Bytes header(reply.begin(), reply.begin() + 7);
    EXPECT_EQ(header, (Bytes{0x12, 0x34, 0, 0, 0, static_cast<std::uint8_t>(size - 6), unit}));
    return {reply.begin() + 7, reply.begin() + static_cast<std::ptrdiff_t>(size)};
}

TEST(CellModbus, ReadsAsTheProtocolsExample) {
    Bank bank;
    EXPECT_EQ(answer(bank, {3, 0x00, 0x6B, 0x00, 0x03}), (Bytes{3, 6, 0x02, 0x2B, 0x00, 0x00, 0x00, 0x64}));
    EXPECT_EQ(answer(bank, {4, 0x00, 0x6B, 0x00, 0x01}), (Bytes{4, 2, 0x02, 0x2B}));
}

TEST(CellModbus, WritesAsTheProtocolsExamples) {
    Bank bank;
    EXPECT_EQ(answer(bank, {6, 0x00, 0x01, 0x00, 0x03}), (Bytes{6, 0x00, 0x01, 0x00, 0x03}));
    EXPECT_EQ(bank.words[1], 3);
    EXPECT_EQ(answer(bank, {16, 0x00, 0x01, 0x00, 0x02, 4, 0x00, 0x0A, 0x01, 0x02}),
              (Bytes{16, 0x00, 0x01, 0x00, 0x02}));
    EXPECT_EQ(bank.words[1], 0x0A);
    EXPECT_EQ(bank.words[2], 0x102);
    // Function 23 writes before it reads.
    EXPECT_EQ(answer(bank, {23, 0x00, 0x01, 0x00, 0x01, 0x00, 0x01, 0x00, 0x01, 2, 0x00, 0x7F}),
              (Bytes{23, 2, 0x00, 0x7F}));
}

TEST(CellModbus, BadRequestsGetTheirException) {
    Bank bank;
    const auto exception = [&](const Bytes& pdu, std::uint8_t unit = 1) {
        const Bytes reply = answer(bank, pdu, unit);
        if (reply.size() != 2 || reply[0] != (pdu[0] | 0x80)) return -1;
        return int{reply[1]};
    };
    EXPECT_EQ(exception({7}), 1);
    EXPECT_EQ(exception({43, 14, 1, 0}), 1);
    EXPECT_EQ(exception({3, 0, 0, 0, 0}), 3) << "no register";
    EXPECT_EQ(exception({3, 0, 0, 0, 126}), 3) << "more than 125";
    EXPECT_EQ(exception({3, 0, 0, 0}), 3) << "cut off";
    EXPECT_EQ(exception({3, 0, 0, 0, 1, 0}), 3) << "too long";
    EXPECT_EQ(exception({3, 0, 199, 0, 2}), 2);
    EXPECT_EQ(exception({3, 0xFF, 0xFF, 0, 2}), 2) << "beyond the last address";
    EXPECT_EQ(exception({16, 0, 1, 0, 2, 3, 0, 1, 0}), 3) << "byte count";
    EXPECT_EQ(exception({16, 0, 1, 0, 0, 0}), 3);
    EXPECT_EQ(exception({16, 0, 1, 0, 200, 0x90}), 3);
    EXPECT_EQ(exception({16, 0, 1, 0, 1, 2, 0, 1, 0}), 3) << "a byte more";
    EXPECT_EQ(exception({6, 1, 0, 0, 1}), 2);
    EXPECT_EQ(exception({23, 0, 199, 0, 2, 0, 1, 0, 1, 2, 0, 1}), 2) << "cannot read, so does not write";
    EXPECT_EQ(bank.writes, 0);
    EXPECT_EQ(exception({3, 0, 0, 0, 1}, 2), 0x0B) << "another unit";
    EXPECT_EQ(answer(bank, {3, 0, 1, 0, 1}, 255), (Bytes{3, 2, 0, 0}));
    EXPECT_EQ(answer(bank, {3, 0, 1, 0, 1}, 0), (Bytes{3, 2, 0, 0}));
}

TEST(CellModbus, AStreamIsCutWhereRequestsEnd) {
    const Bytes whole = frame({3, 0, 0, 0, 1});
    for (std::size_t size = 0; size < whole.size(); ++size)
        EXPECT_EQ(cut_request(std::span(whole).first(size)).kind, RequestCut::Kind::part) << size;
    Bytes two = whole;
    two.insert(two.end(), whole.begin(), whole.end());
    EXPECT_EQ(cut_request(two).size, whole.size());
    Bytes other_protocol = whole, no_function = whole, too_long = whole;
    other_protocol[3] = 1;
    no_function[5] = 1;
    too_long[4] = 1;
    for (const auto& bad : {other_protocol, no_function, too_long})
        EXPECT_EQ(cut_request(bad).kind, RequestCut::Kind::garbled);
}

}  // namespace
}  // namespace cmm::cell
