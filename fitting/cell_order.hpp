// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cmm::fitting {

/// The order in which items of the same cell follow each other (counting sort), cells below `cells`. Empty: they
/// follow each other as they are, for the most part.
inline std::vector<std::uint32_t> order_by_cell(std::span<const std::uint16_t> cell, std::size_t cells) {
    std::vector<std::uint32_t> first(cells + 1, 0);
    std::size_t jumps = 0;
    for (std::size_t i = 0; i < cell.size(); ++i) {
        ++first[cell[i] + 1U];
        jumps += i > 0 && cell[i] != cell[i - 1];
    }
    if (jumps < cell.size() / 4) return {};
    for (std::size_t c = 1; c <= cells; ++c)
        first[c] += first[c - 1];
    std::vector<std::uint32_t> order(cell.size());
    for (std::size_t i = 0; i < cell.size(); ++i)
        order[first[cell[i]]++] = static_cast<std::uint32_t>(i);
    return order;
}

}  // namespace cmm::fitting
