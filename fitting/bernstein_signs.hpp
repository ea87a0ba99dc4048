// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace cmm::fitting {

/// Bit i: the sign of coefficient i.
inline unsigned negative_signs(const std::array<double, 6>& beta) {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < 6; ++i)
        bits |= std::bit_cast<std::uint64_t>(beta[i]) >> 63 << i;
    return static_cast<unsigned>(bits);
}

constexpr unsigned all_negative = 63;
/// Negative first, then positive: one minimum inside (variation diminution: as many roots as sign changes, or fewer by
/// an even number).
constexpr bool one_minimum(unsigned negative) {
    return (negative & (negative + 1)) == 0;
}
constexpr bool one_maximum(unsigned negative) {
    return one_minimum(~negative & all_negative);
}

}  // namespace cmm::fitting
