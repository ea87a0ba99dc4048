// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <type_traits>

namespace cmm::core {

/// Bits of `Sample::flags`, as the controller set them.
namespace sample_flag {
inline constexpr std::uint16_t no_contact = 1U << 0;      ///< the stylus was off the surface: no measurement
inline constexpr std::uint16_t over_deflected = 1U << 1;  ///< deflection outside the linear range
inline constexpr std::uint16_t touch = 1U << 2;           ///< taken by a touch, not by a scan
inline constexpr std::uint16_t apart = 1U << 3;           ///< taken by hand at another height than the section's
}  // namespace sample_flag

/// One recorded point, as the controller gave it: counts are kept, not re-rounded doubles. Trivially copyable.
struct Sample {
    std::uint64_t sequence = 0;            ///< 1, 2, 3, ... over the whole run, without gaps
    std::int64_t machine_time_us = 0;      ///< controller clock
    std::int64_t host_time_ns = 0;         ///< host monotonic clock when the sample came off the wire
    std::array<std::int32_t, 3> counts{};  ///< ball centre in machine counts
    std::uint16_t path = 0;                ///< the path under which it was taken
    std::uint16_t flags = 0;               ///< sample_flag bits
    std::int32_t deflection_counts = 0;    ///< probe deflection; 0 where the probe has none
};
static_assert(std::is_trivially_copyable_v<Sample>);

/// Whether the sample is a point of the section that its path measures; the others are kept, no more.
inline bool of_section(const Sample& sample) {
    return (sample.flags & (sample_flag::touch | sample_flag::apart)) == 0;
}

/// The ball centre in millimetres, machine frame. `lsb_mm` is the controller's count size (identity registers).
inline Eigen::Vector3d centre_mm(const Sample& sample, double lsb_mm) {
    return {sample.counts[0] * lsb_mm, sample.counts[1] * lsb_mm, sample.counts[2] * lsb_mm};
}

}  // namespace cmm::core
