// SPDX-License-Identifier: Apache-2.0
#include "fitting/small_system.hpp"

#include <Eigen/Cholesky>

namespace cmm::fitting {

SmallVector solve_small(const SmallMatrix& matrix, const SmallVector& rhs) {
    return matrix.ldlt().solve(rhs);
}

SmallMatrix inverse_of_small(const SmallMatrix& matrix) {
    return matrix.ldlt().solve(SmallMatrix::Identity(matrix.rows(), matrix.cols()));
}

}  // namespace cmm::fitting
