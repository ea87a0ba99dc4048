// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace cmm::fitting {

/// Symmetric, positive semi-definite systems of few unknowns, of which only the lower triangle is read. One solver for
/// all sizes: the compiler needs seconds for each fixed one.
inline constexpr int most_unknowns = 11;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, most_unknowns, most_unknowns>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, most_unknowns, 1>;

SmallVector solve_small(const SmallMatrix& matrix, const SmallVector& rhs);
SmallMatrix inverse_of_small(const SmallMatrix& matrix);

}  // namespace cmm::fitting
