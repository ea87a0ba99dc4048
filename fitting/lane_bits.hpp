// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

/// Which of eight numbers side by side matter, found and listed without a branch, since that is not to be foretold.
namespace cmm::fitting {

inline constexpr std::size_t lane_count = 8;
using FloatLanes = Eigen::Array<float, lane_count, 1>;

/// A bit for each of the values that compares so. Not inline, so that the compiler keeps the loop, of which it makes
/// vector lanes.
template <class Compare>
[[gnu::noinline]] std::uint32_t lanes_where(const FloatLanes& values, Compare compare, float with) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < lane_count; ++k)
        bits |= static_cast<std::uint32_t>(compare(values[static_cast<Eigen::Index>(k)], with)) << k;
    return bits;
}

/// The places of a byte's ones, in order.
inline constexpr auto places_of_ones = [] {
    std::array<std::array<std::uint32_t, lane_count>, 1 << lane_count> places{};
    for (std::uint32_t bits = 0; bits < places.size(); ++bits)
        for (std::uint32_t k = 0, count = 0; k < lane_count; ++k)
            if (((bits >> k) & 1U) != 0) places[bits][count++] = k;
    return places;
}();

/// Writes the numbers of the lanes whose bits are set, counted from `first`, and something behind them: there is room
/// for all lanes. How many are set.
inline std::size_t list_lanes(std::uint32_t bits, std::uint32_t first, std::uint32_t* to) {
    for (std::size_t k = 0; k < lane_count; ++k)
        to[k] = first + places_of_ones[bits][k];
    return static_cast<std::size_t>(std::popcount(bits));
}

}  // namespace cmm::fitting
