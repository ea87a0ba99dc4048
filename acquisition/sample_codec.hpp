// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "core/sample.hpp"

namespace cmm::acquisition {

/// CRC-32 (IEEE 802.3, reflected, as in zip and PNG).
std::uint32_t crc32(std::span<const std::uint8_t> bytes) noexcept;

inline constexpr std::size_t max_batch_samples = 4096;

/// Packs samples without loss: every field is a column of second differences (a scan at constant speed leaves small
/// numbers), zig-zag variable-length integers, zstd level 3, CRC-32 of the packed columns. One owner, no locking; keeps
/// its work space from call to call.
class SampleEncoder {
  public:
    SampleEncoder();
    ~SampleEncoder();
    SampleEncoder(const SampleEncoder&) = delete;
    SampleEncoder& operator=(const SampleEncoder&) = delete;

    /// The batch as bytes; valid until the next call. At most `max_batch_samples`. Errors: internal.
    core::Result<std::span<const std::uint8_t>> encode(std::span<const core::Sample> samples);

  private:
    struct Space;
    std::unique_ptr<Space> space_;
};

/// Unpacks into `samples` (replaced). Errors: journal_corrupt (length, CRC, format).
core::Status decode_samples(std::span<const std::uint8_t> bytes, std::vector<core::Sample>& samples);

}  // namespace cmm::acquisition
