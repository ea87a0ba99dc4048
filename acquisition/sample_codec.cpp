// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sample_codec.hpp"

#include <zstd.h>

#include <array>
#include <string>

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::Sample;

// Layout of a batch: format (1), count (2), CRC-32 of the columns (4), all little-endian, then the zstd frame.
constexpr std::uint8_t format_1 = 1;
constexpr std::size_t head_bytes = 7;
constexpr int zstd_level = 3;
constexpr std::size_t max_varint_bytes = 10;
constexpr std::size_t columns = 9;
constexpr std::size_t max_column_bytes = columns * max_batch_samples * max_varint_bytes;

constexpr std::array<std::uint32_t, 256> make_crc_table() {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t n = 0; n < table.size(); ++n) {
        std::uint32_t c = n;
        for (int bit = 0; bit < 8; ++bit)
            c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1U) : c >> 1U;
        table[n] = c;
    }
    return table;
}
constexpr auto crc_table = make_crc_table();

/// Calls `visit(get, set)` for every field of a sample. The one list of fields that both directions share.
template <class Visit>
void for_each_column(const Visit& visit) {
    visit([](const Sample& s) { return s.sequence; }, [](Sample& s, std::uint64_t v) { s.sequence = v; });
    visit([](const Sample& s) { return static_cast<std::uint64_t>(s.machine_time_us); },
          [](Sample& s, std::uint64_t v) { s.machine_time_us = static_cast<std::int64_t>(v); });
    visit([](const Sample& s) { return static_cast<std::uint64_t>(s.host_time_ns); },
          [](Sample& s, std::uint64_t v) { s.host_time_ns = static_cast<std::int64_t>(v); });
    for (std::size_t axis = 0; axis < 3; ++axis) {
        visit([axis](const Sample& s) { return static_cast<std::uint64_t>(s.counts[axis]); },
              [axis](Sample& s, std::uint64_t v) { s.counts[axis] = static_cast<std::int32_t>(v); });
    }
    visit([](const Sample& s) { return std::uint64_t{s.path}; },
          [](Sample& s, std::uint64_t v) { s.path = static_cast<std::uint16_t>(v); });
    visit([](const Sample& s) { return std::uint64_t{s.flags}; },
          [](Sample& s, std::uint64_t v) { s.flags = static_cast<std::uint16_t>(v); });
    visit([](const Sample& s) { return static_cast<std::uint64_t>(s.deflection_counts); },
          [](Sample& s, std::uint64_t v) { s.deflection_counts = static_cast<std::int32_t>(v); });
}

void put_varint(std::vector<std::uint8_t>& out, std::uint64_t value) {
    for (; value >= 0x80U; value >>= 7U)
        out.push_back(static_cast<std::uint8_t>(value | 0x80U));
    out.push_back(static_cast<std::uint8_t>(value));
}

bool take_varint(std::span<const std::uint8_t>& in, std::uint64_t& value) {
    value = 0;
    for (std::size_t i = 0; i < in.size() && i < max_varint_bytes; ++i) {
        value |= std::uint64_t{in[i] & 0x7FU} << (7 * i);
        if ((in[i] & 0x80U) == 0) {
            in = in.subspan(i + 1);
            return true;
        }
    }
    return false;
}

// Differences are taken modulo 2^64, so every value of every field comes back.
std::uint64_t zig_zag(std::uint64_t v) {
    return (v << 1U) ^ (0 - (v >> 63U));
}
std::uint64_t zig_zag_back(std::uint64_t v) {
    return (v >> 1U) ^ (0 - (v & 1U));
}

auto corrupt(const std::string& what) {
    return core::fail(ErrorCode::journal_corrupt, "sample batch: " + what);
}

std::uint32_t take_le(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t width) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < width; ++i)
        value |= std::uint32_t{bytes[at + i]} << (8 * i);
    return value;
}

bool unpack_columns(std::span<const std::uint8_t> in, std::vector<Sample>& samples) {
    bool whole = true;
    for_each_column([&](const auto&, const auto& set) {
        std::uint64_t value = 0;
        std::uint64_t step = 0;
        for (auto& sample : samples) {
            std::uint64_t packed = 0;
            whole = whole && take_varint(in, packed);
            step += zig_zag_back(packed);
            value += step;
            set(sample, value);
        }
    });
    return whole && in.empty();
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes) noexcept {
    std::uint32_t c = 0xFFFFFFFFU;
    for (const auto byte : bytes)
        c = crc_table[(c ^ byte) & 0xFFU] ^ (c >> 8U);
    return c ^ 0xFFFFFFFFU;
}

struct SampleEncoder::Space {
    std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd{ZSTD_createCCtx(), &ZSTD_freeCCtx};
    std::vector<std::uint8_t> packed;
    std::vector<std::uint8_t> out;
};

SampleEncoder::SampleEncoder() : space_(std::make_unique<Space>()) {}
SampleEncoder::~SampleEncoder() = default;

core::Result<std::span<const std::uint8_t>> SampleEncoder::encode(std::span<const core::Sample> samples) {
    if (samples.size() > max_batch_samples) return core::fail(ErrorCode::internal, "sample batch is too long");
    auto& packed = space_->packed;
    packed.clear();
    for_each_column([&](const auto& get, const auto&) {
        std::uint64_t value = 0;
        std::uint64_t step = 0;
        for (const auto& sample : samples) {
            const std::uint64_t next = get(sample);
            put_varint(packed, zig_zag(next - value - step));
            step = next - value;
            value = next;
        }
    });
    auto& out = space_->out;
    out.resize(head_bytes + ZSTD_compressBound(packed.size()));
    const auto crc = crc32(packed);
    out[0] = format_1;
    for (std::size_t i = 0; i < 2; ++i)
        out[1 + i] = static_cast<std::uint8_t>(samples.size() >> (8 * i));
    for (std::size_t i = 0; i < 4; ++i)
        out[3 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
    const auto size = ZSTD_compressCCtx(space_->zstd.get(), out.data() + head_bytes, out.size() - head_bytes,
                                        packed.data(), packed.size(), zstd_level);
    if (ZSTD_isError(size) != 0) return core::fail(ErrorCode::internal, ZSTD_getErrorName(size));
    return std::span<const std::uint8_t>(out).first(head_bytes + size);
}

core::Status decode_samples(std::span<const std::uint8_t> bytes, std::vector<core::Sample>& samples) {
    if (bytes.size() < head_bytes) return corrupt("too short");
    if (bytes[0] != format_1) return corrupt("unknown format " + std::to_string(bytes[0]));
    const std::size_t count = take_le(bytes, 1, 2);
    if (count > max_batch_samples) return corrupt("impossible count " + std::to_string(count));
    const auto frame = bytes.subspan(head_bytes);
    const auto size = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > max_column_bytes) {
        return corrupt("no valid zstd frame");
    }
    std::vector<std::uint8_t> packed(size);
    const auto got = ZSTD_decompress(packed.data(), packed.size(), frame.data(), frame.size());
    if (ZSTD_isError(got) != 0 || got != size) return corrupt("zstd frame is damaged");
    if (crc32(packed) != take_le(bytes, 3, 4)) return corrupt("CRC-32 does not match");
    samples.assign(count, Sample{});
    if (!unpack_columns(packed, samples)) return corrupt("columns do not hold the count");
    return {};
}

}  // namespace cmm::acquisition
