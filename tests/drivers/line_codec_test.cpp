// SPDX-License-Identifier: Apache-2.0
#include "drivers/line/line_codec.hpp"

#include <gtest/gtest.h>

#include "core/rng.hpp"
#include "drivers/line/line_messages.hpp"
#include "sim/line_codec.hpp"

namespace cmm::drivers::line {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Kind = Message::Kind;

Bytes bytes_of(const std::string& text) {
    return {text.begin(), text.end()};
}

std::vector<Message> parsed(Parser& parser, const Bytes& bytes) {
    std::vector<Message> messages;
    parser.feed(bytes, messages);
    return messages;
}

TEST(LineCodec, ChecksumsAreThoseOfTheCatalogue) {
    EXPECT_EQ(crc16("123456789"), 0x29B1);
    EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF43926U);
    EXPECT_EQ(command_line(7, "ST"), "#7 ST*4DF5\n");
}

// The examples of Cheshire and Baker's article and of every description since.
TEST(LineCodec, CobsIsUndone) {
    const auto expect = [](const Bytes& encoded, const Bytes& plain) {
        const auto decoded = cobs_decoded(encoded);
        ASSERT_TRUE(decoded);
        EXPECT_EQ(*decoded, plain);
    };
    expect({1, 1}, {0});
    expect({1, 1, 1}, {0, 0});
    expect({3, 0x11, 0x22, 2, 0x33}, {0x11, 0x22, 0, 0x33});
    expect({2, 0x11, 1, 1, 1}, {0x11, 0, 0, 0});
    Bytes plain, encoded{0xFF};
    for (int k = 1; k <= 254; ++k)
        plain.push_back(static_cast<std::uint8_t>(k));
    encoded.insert(encoded.end(), plain.begin(), plain.end());
    expect(encoded, plain);
    encoded.insert(encoded.end(), {2, 0xFF});
    plain.push_back(0xFF);
    expect(encoded, plain);
    EXPECT_FALSE(cobs_decoded(Bytes{5, 1, 2})) << "cut off";
    EXPECT_FALSE(cobs_decoded(Bytes{3, 1, 0})) << "a zero inside";
}

/// A frame of the simulator's writer, which shares no code with the parser.
struct Frame {
    std::vector<std::array<std::int32_t, 3>> counts;
    std::vector<std::int64_t> since_us;
    Bytes bytes;
    explicit Frame(std::uint64_t seed, std::size_t count, std::int64_t reach) {
        core::Rng rng(seed);
        sim::FrameWriter out;
        out.put('S', 1);
        out.put(513, 2);
        out.put(77, 2);
        out.put(4, 1);
        out.put(2, 1);
        out.put(9, 2);
        out.put(100, 4);
        out.put(100 + count, 4);
        out.put(5'000'000'000, 8);
        out.put(count, 2);
        std::array<sim::LineRow, 4> rows;
        for (std::size_t k = 0; k < count; ++k) {
            counts.emplace_back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto off =
                    static_cast<std::int64_t>(rng.below(static_cast<std::uint64_t>(2 * reach + 1))) - reach;
                counts.back()[axis] = static_cast<std::int32_t>(off);
                rows[axis].put(out, off);
            }
            since_us.push_back(static_cast<std::int64_t>(1000 * k + rng.below(3)));
            rows[3].put(out, since_us.back());
            out.put_varint(k == 3 ? 0x0901 : 0);
        }
        bytes = out.finished();
    }
};

TEST(LineCodec, SampleFramesOfTheSimulatorAreRead) {
    for (const std::int64_t reach : {std::int64_t{3}, std::int64_t{100'000}, std::int64_t{2'147'483'647}}) {
        const Frame frame(static_cast<std::uint64_t>(reach), 64, reach);
        Parser parser;
        const auto messages = parsed(parser, frame.bytes);
        ASSERT_EQ(messages.size(), 1U);
        EXPECT_EQ(messages[0].tag, 513);
        const auto samples = decode_samples(messages[0].payload);
        ASSERT_TRUE(samples) << samples.error().text();
        EXPECT_EQ(samples->boot_id, 77);
        EXPECT_EQ(samples->block.newest, 164U);
        EXPECT_TRUE(samples->block.more());
        ASSERT_EQ(samples->samples.size(), 64U);
        for (std::size_t k = 0; k < 64; ++k) {
            EXPECT_EQ(samples->samples[k].counts, frame.counts[k]);
            EXPECT_EQ(samples->samples[k].machine_time_us, 5'000'000'000 + frame.since_us[k]);
            EXPECT_EQ(samples->samples[k].sequence, 100 + k);
        }
        EXPECT_EQ(samples->samples[3].flags, 1);
        EXPECT_EQ(samples->samples[3].deflection_counts, 9);
        for (std::size_t cut = 0; cut < messages[0].payload.size(); ++cut)
            EXPECT_FALSE(decode_samples(std::span(messages[0].payload).first(cut))) << cut;
    }
}

TEST(LineParser, MessagesComeWholeHoweverTheyAreCut) {
    const Frame frame(1, 20, 500);
    Bytes stream = bytes_of(sim::line_reply('=', 4, "1 2"));
    stream.insert(stream.end(), frame.bytes.begin(), frame.bytes.end());
    for (const std::uint8_t byte : bytes_of(sim::line_reply('!', 5, "6")))
        stream.push_back(byte);
    Parser parser;
    std::vector<Message> messages;
    for (const std::uint8_t byte : stream)
        parser.feed({&byte, 1}, messages);
    ASSERT_EQ(messages.size(), 3U);
    EXPECT_EQ(messages[0].text, "1 2");
    EXPECT_EQ(messages[1].kind, Kind::samples);
    EXPECT_EQ(messages[2].kind, Kind::refusal);
    EXPECT_EQ(messages[2].tag, 5);
    EXPECT_EQ(parser.spoilt(), 0U);
}

TEST(LineParser, WhateverIsLostOrFlippedNoMessageIsWrong) {
    const Frame frame(2, 20, 500);
    const std::string reply = sim::line_reply('=', 4, "1 2 3");
    Bytes once = bytes_of(reply);
    once.insert(once.end(), frame.bytes.begin(), frame.bytes.end());
    for (std::size_t at = 0; at < once.size(); ++at) {
        for (int bit = -1; bit < 8; ++bit) {  // -1: the byte is lost
            Bytes stream = once;
            if (bit < 0) {
                stream.erase(stream.begin() + static_cast<std::ptrdiff_t>(at));
            } else {
                stream[at] = static_cast<std::uint8_t>(stream[at] ^ (1U << static_cast<unsigned>(bit)));
            }
            Parser parser;
            auto messages = parsed(parser, stream);
            EXPECT_LE(messages.size(), 2U);
            for (const Message& message : messages) {
                EXPECT_EQ(message.text, message.kind == Kind::answer ? "1 2 3" : "");
                EXPECT_EQ(message.tag, message.kind == Kind::samples ? 513 : 4);
            }
            parser.reset();  // as after a time-out: the repetition is understood
            EXPECT_EQ(parsed(parser, once).size(), 2U) << at << " " << bit;
        }
    }
}

TEST(LineMessages, WhatIsNoAnswerIsRefused) {
    EXPECT_EQ(decode_identity("GRBL 1").error().code, core::ErrorCode::protocol_mismatch);
    EXPECT_EQ(decode_identity("CMM1 2").error().code, core::ErrorCode::protocol_mismatch);
    EXPECT_FALSE(decode_identity("CMM1 1 100"));
    EXPECT_FALSE(decode_status(""));
    EXPECT_FALSE(decode_status("1 2 3"));
    const std::string status = "7 4 1 3 0 5 1 0 0 0 0 0 2 10 20 30 25 -1 -2 -3 5 123456789012 99";
    const auto good = decode_status(status);
    ASSERT_TRUE(good) << good.error().text();
    EXPECT_EQ(good->block.state, 4);
    EXPECT_EQ(good->block.position[2], -3);
    EXPECT_EQ(good->block.time_us, 123456789012);
    EXPECT_EQ(good->block.owner, 99U);
    EXPECT_FALSE(decode_status(status + " 1"));
    EXPECT_FALSE(decode_status("7 44" + status.substr(3)));
}

}  // namespace
}  // namespace cmm::drivers::line
