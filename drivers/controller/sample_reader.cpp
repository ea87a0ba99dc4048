// SPDX-License-Identifier: Apache-2.0
#include "drivers/controller/sample_reader.hpp"

#include <algorithm>
#include <string>

namespace cmm::drivers::controller {

void SampleReader::begin(const RunOrigin& origin, std::uint32_t acknowledged) {
    origin_ = origin;
    const auto last = static_cast<std::int64_t>(origin.last_sequence) - origin.sequence_shift;
    next_ = static_cast<std::uint32_t>(last + 1);
    durable_ = acknowledged;
}

std::uint64_t SampleReader::run_sequence(std::uint32_t controller_sequence) const noexcept {
    return static_cast<std::uint64_t>(std::max<std::int64_t>(0, controller_sequence + origin_.sequence_shift));
}

core::Result<std::span<const core::Sample>> SampleReader::take(const FifoBlock& block, std::span<core::Sample> samples,
                                                               std::int64_t host_time_ns, Asked asked) {
    // It may have been answered earlier than a block before it that had to be repeated.
    const bool follows = block.count > 0 && block.first <= next_;
    if (asked == Asked::ahead && !follows) return std::span<const core::Sample>();
    if (asked == Asked::due && block.newest + 1 < next_) {
        return core::fail(core::ErrorCode::protocol_invalid,
                          "the controller's newest sample is " + std::to_string(block.newest) + ", but it has sent " +
                              std::to_string(next_ - 1) + " already: its numbering went back");
    }
    if (block.count == 0) return std::span<const core::Sample>();
    if (block.first > next_) {
        const auto code = block.overflow() ? core::ErrorCode::machine_overflow : core::ErrorCode::protocol_invalid;
        return core::fail(code, "samples " + std::to_string(run_sequence(next_)) + " to " +
                                    std::to_string(run_sequence(block.first - 1)) + " are missing" +
                                    (block.overflow() ? ": the controller's FIFO ran full" : ""));
    }
    const std::size_t known = std::min<std::size_t>(next_ - block.first, samples.size());
    duplicates_ += known;
    const auto fresh = samples.subspan(known);
    for (core::Sample& sample : fresh) {
        sample.sequence = run_sequence(static_cast<std::uint32_t>(sample.sequence));
        sample.host_time_ns = host_time_ns;
    }
    next_ += static_cast<std::uint32_t>(fresh.size());
    return std::span<const core::Sample>(fresh);
}

void SampleReader::durable(std::uint64_t run_sequence) {
    const std::uint64_t safe = std::min(run_sequence, last_delivered());
    const std::int64_t number = static_cast<std::int64_t>(safe) - origin_.sequence_shift;
    if (number > static_cast<std::int64_t>(durable_)) durable_ = static_cast<std::uint32_t>(number);
}

}  // namespace cmm::drivers::controller
