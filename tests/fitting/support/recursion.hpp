// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>

namespace cmm::fitting::truth {

/// N_{i,degree}(t) straight from the recursion of seed 000, eq 7: spans half open, 0/0 = 0.
inline double basis(std::span<const double> knots, std::size_t i, int degree, double t) {
    if (degree == 0) return knots[i] <= t && t < knots[i + 1] ? 1.0 : 0.0;
    const auto d = static_cast<std::size_t>(degree);
    const double rise = knots[i + d] - knots[i], fall = knots[i + d + 1] - knots[i + 1];
    double sum = 0.0;
    if (rise > 0.0) sum += (t - knots[i]) / rise * basis(knots, i, degree - 1, t);
    if (fall > 0.0) sum += (knots[i + d + 1] - t) / fall * basis(knots, i + 1, degree - 1, t);
    return sum;
}

}  // namespace cmm::fitting::truth
