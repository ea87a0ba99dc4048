// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sample_codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string_view>

#include "core/rng.hpp"

namespace cmm::acquisition {
namespace {

using core::Sample;

bool same(const Sample& a, const Sample& b) {
    return a.sequence == b.sequence && a.machine_time_us == b.machine_time_us && a.host_time_ns == b.host_time_ns &&
           a.counts == b.counts && a.path == b.path && a.flags == b.flags && a.deflection_counts == b.deflection_counts;
}

void expect_round_trip(const std::vector<Sample>& samples) {
    SampleEncoder encoder;
    const auto bytes = encoder.encode(samples);
    ASSERT_TRUE(bytes);
    std::vector<Sample> back{Sample{}};
    ASSERT_TRUE(decode_samples(*bytes, back));
    ASSERT_EQ(back.size(), samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i)
        ASSERT_TRUE(same(samples[i], back[i])) << "sample " << i;
}

std::vector<Sample> scan_of(std::size_t count) {
    std::vector<Sample> samples(count);
    core::Rng rng(7);
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 0.003 * static_cast<double>(i);
        auto& s = samples[i];
        s.sequence = i + 1;
        s.machine_time_us = static_cast<std::int64_t>(1000 * i);
        s.host_time_ns =
            static_cast<std::int64_t>(1'000'000 * (i / 15 * 15)) + static_cast<std::int64_t>(rng.below(40'000));
        s.counts = {static_cast<std::int32_t>(400'000 * std::cos(angle) + 10 * rng.normal()),
                    static_cast<std::int32_t>(100'000 * std::sin(angle) + 10 * rng.normal()), 1'000'000};
        s.path = 3;
    }
    return samples;
}

TEST(SampleCodec, CrcIsTheWellKnownOne) {
    constexpr std::string_view check = "123456789";
    EXPECT_EQ(crc32(std::span(reinterpret_cast<const std::uint8_t*>(check.data()), check.size())), 0xCBF43926U);
}

TEST(SampleCodec, ScansComeBackBitForBit) {
    expect_round_trip(scan_of(4096));
}

TEST(SampleCodec, EmptyAndSingleBatches) {
    expect_round_trip({});
    expect_round_trip(scan_of(1));
}

TEST(SampleCodec, ExtremeAndRandomValuesComeBackBitForBit) {
    core::Rng rng(11);
    std::vector<Sample> samples(1000);
    for (auto& s : samples) {
        s.sequence = rng.next();
        s.machine_time_us = static_cast<std::int64_t>(rng.next());
        s.host_time_ns = static_cast<std::int64_t>(rng.next());
        for (auto& count : s.counts)
            count = static_cast<std::int32_t>(rng.next());
        s.path = static_cast<std::uint16_t>(rng.next());
        s.flags = static_cast<std::uint16_t>(rng.next());
        s.deflection_counts = static_cast<std::int32_t>(rng.next());
    }
    samples[0].machine_time_us = std::numeric_limits<std::int64_t>::min();
    samples[1].machine_time_us = std::numeric_limits<std::int64_t>::max();
    samples[2].counts = {std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max(), 0};
    samples[3].sequence = std::numeric_limits<std::uint64_t>::max();
    expect_round_trip(samples);
}

TEST(SampleCodec, AScanIsSmall) {
    const auto samples = scan_of(2000);
    SampleEncoder encoder;
    const auto bytes = encoder.encode(samples);
    ASSERT_TRUE(bytes);
    EXPECT_LT(bytes->size(), 2000 * 9U) << "of " << 2000 * sizeof(Sample);
}

TEST(SampleCodec, TooLongABatchIsRefused) {
    SampleEncoder encoder;
    EXPECT_FALSE(encoder.encode(scan_of(max_batch_samples + 1)));
}

TEST(SampleCodec, EveryFlippedBitIsFound) {
    const auto samples = scan_of(300);
    SampleEncoder encoder;
    const auto bytes = encoder.encode(samples);
    ASSERT_TRUE(bytes);
    const std::vector<std::uint8_t> good(bytes->begin(), bytes->end());
    std::vector<Sample> back;
    std::size_t silent = 0;
    for (std::size_t i = 0; i < good.size(); ++i) {
        for (int bit = 0; bit < 8; ++bit) {
            auto bad = good;
            bad[i] = static_cast<std::uint8_t>(bad[i] ^ (1U << bit));
            const auto status = decode_samples(bad, back);
            if (!status) {
                EXPECT_EQ(status.error().code, core::ErrorCode::journal_corrupt);
                continue;
            }
            // A bit of the frame that carries no data (zstd's reserved bits): then nothing may have changed.
            ASSERT_EQ(back.size(), samples.size());
            for (std::size_t k = 0; k < back.size(); ++k)
                silent += same(back[k], samples[k]) ? 0U : 1U;
        }
    }
    EXPECT_EQ(silent, 0U);
}

TEST(SampleCodec, EveryShortenedBatchIsFound) {
    SampleEncoder encoder;
    const auto bytes = encoder.encode(scan_of(100));
    ASSERT_TRUE(bytes);
    std::vector<Sample> back;
    for (std::size_t size = 0; size < bytes->size(); ++size) {
        const auto status = decode_samples(bytes->first(size), back);
        ASSERT_FALSE(status) << size;
        EXPECT_EQ(status.error().code, core::ErrorCode::journal_corrupt);
    }
}

}  // namespace
}  // namespace cmm::acquisition
