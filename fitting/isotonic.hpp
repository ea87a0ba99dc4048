// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cmm::fitting {

/// The ascending values nearest to these by squares: pool adjacent violators (Ayer, Brunk, Ewing, Reid, Silverman
/// 1955).
inline void make_ascending(std::span<double> values) {
    struct Pool {
        double sum;
        std::size_t count;
        double mean() const { return sum / static_cast<double>(count); }
    };
    std::vector<Pool> pools;
    for (const double value : values) {
        Pool now{value, 1};
        while (!pools.empty() && pools.back().mean() > now.mean()) {
            now.sum += pools.back().sum;
            now.count += pools.back().count;
            pools.pop_back();
        }
        pools.push_back(now);
    }
    std::size_t at = 0;
    for (const Pool& pool : pools)
        for (std::size_t k = 0; k < pool.count; ++k)
            values[at++] = pool.mean();
}

}  // namespace cmm::fitting
