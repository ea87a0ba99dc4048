// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/error.hpp"

namespace cmm::fitting {

/// The x for which the largest |r_i - a_i x| is smallest, and what it rests on.
struct ChebyshevFit {
    Eigen::VectorXd x;
    double level = 0.0;               ///< that largest value
    std::vector<std::size_t> active;  ///< rows that have it; one more than x has numbers
    Eigen::MatrixXd by_active;        ///< of x by r of the active rows, first order
    int exchanges = 0;
};

/// Linear Chebyshev approximation by exchange of one row (Stiefel, Numer. Math. 1, 1959): the dual simplex method of
/// the linear programme, exact to rounding in finitely many steps. `rows`: n x d, d from 1 to 3 or so, n > d. Errors:
/// fit_not_evaluable (too few rows, rows that do not determine x, no end of the exchanges).
core::Result<ChebyshevFit> chebyshev_fit(const Eigen::MatrixXd& rows, const Eigen::VectorXd& r);

}  // namespace cmm::fitting
