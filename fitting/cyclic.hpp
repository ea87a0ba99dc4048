// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace cmm::fitting {

/// The place of `i`, less than 2 `n`, in a closed sequence of `n`. A division takes longer than most of what loops do
/// with a point.
inline std::size_t cyclic(std::size_t i, std::size_t n) {
    return i < n ? i : i - n;
}

}  // namespace cmm::fitting
