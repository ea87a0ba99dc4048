// SPDX-License-Identifier: Apache-2.0
#include "fitting/band_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/rng.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {
namespace {

/// Against a dense solver, on random diagonally dominant matrices.
template <int W>
void compare(std::size_t n, bool cyclic) {
    core::Rng rng(n);
    BandSolver<W> band(n, cyclic);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(n));
    const auto add = [&](std::size_t i, std::size_t j, double value) {
        band.add(i, j, value);
        dense(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) += value;
        if (i != j) dense(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(i)) += value;
    };
    for (std::size_t i = 0; i < n; ++i) {
        add(i, i, 2.0 * W + 1.0 + rng.uniform());
        for (std::size_t k = 1; k <= W; ++k)
            if (cyclic || i + k < n) add(i, (i + k) % n, rng.uniform(-1.0, 1.0));
    }
    std::vector<Vec2> rhs(n);
    Eigen::MatrixXd expected(static_cast<Eigen::Index>(n), 2);
    for (std::size_t i = 0; i < n; ++i) {
        rhs[i] = {rng.normal(), rng.normal()};
        expected.row(static_cast<Eigen::Index>(i)) = rhs[i].transpose();
    }
    expected = dense.ldlt().solve(expected).eval();
    ASSERT_TRUE(band.factor());
    band.solve(std::span(rhs));
    for (std::size_t i = 0; i < n; ++i)
        EXPECT_LT((rhs[i] - expected.row(static_cast<Eigen::Index>(i)).transpose()).norm(), 1e-12) << n << " " << i;
}

TEST(BandSolver, AgreesWithADenseSolver) {
    for (const std::size_t n : {7U, 8U, 9U, 12U, 50U}) {
        compare<3>(n, true);
        compare<3>(n, false);
        compare<1>(n, true);
        compare<1>(n, false);
    }
    compare<1>(3, true);
    compare<1>(2, false);
}

TEST(BandSolver, SaysThatAMatrixIsNotPositiveDefinite) {
    BandSolver<1> band(5, true);
    for (std::size_t i = 0; i < 5; ++i) {
        band.add(i, i, 1.0);
        band.add(i, (i + 1) % 5, -1.0);
    }
    EXPECT_FALSE(band.factor());
}

}  // namespace
}  // namespace cmm::fitting
