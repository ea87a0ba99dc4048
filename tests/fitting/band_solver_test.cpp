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
    std::vector<double> column(n);
    for (std::size_t i = 0; i < n; ++i) {
        EXPECT_LT((rhs[i] - expected.row(static_cast<Eigen::Index>(i)).transpose()).norm(), 1e-12) << n << " " << i;
        column[i] = static_cast<double>(i);
    }
    const Eigen::VectorXd answer =
        dense.ldlt().solve(Eigen::Map<const Eigen::VectorXd>(column.data(), static_cast<Eigen::Index>(n)));
    band.solve(std::span(column));
    std::vector<typename BandSolver<W>::Row> inverse;
    band.invert(inverse);
    const Eigen::MatrixXd all = dense.inverse();
    for (std::size_t i = 0; i < n; ++i) {
        EXPECT_NEAR(column[i], answer[static_cast<Eigen::Index>(i)], 1e-11) << n << " " << i;
        for (std::size_t k = 0; k <= W && (cyclic || i + k < n); ++k)
            EXPECT_NEAR(inverse[i][k], all(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>((i + k) % n)), 1e-13)
                << n << " " << i << " " << k;
    }
}

/// Block by block, row by row and element by element.
TEST(BandSolver, TakesItsElementsInThreeWays) {
    constexpr int width = 4;
    for (const bool cyclic : {false, true})
        for (const std::size_t n : {9U, 10U, 11U, 12U, 13U, 14U, 19U, 20U}) {
            core::Rng rng(n);
            BandSolver<width> by_block(n, cyclic), by_row(n, cyclic), by_element(n, cyclic);
            std::vector<BandSolver<width>::Row> rows(n, BandSolver<width>::Row{});
            for (std::size_t first = 0; first < (cyclic ? n : n - width); ++first) {
                BandSolver<width>::Block block{};
                for (std::size_t a = 0; a <= width; ++a)
                    for (std::size_t c = 0; c <= a; ++c) {
                        block[a][c] = (a == c ? 10.0 : 0.0) + rng.uniform(-1.0, 1.0);
                        rows[(first + a) % n][a - c] += block[a][c];
                        by_element.add((first + a) % n, (first + c) % n, block[a][c]);
                    }
                by_block.add_block(first, block);
            }
            for (std::size_t i = 0; i < n; ++i)
                by_row.add_row(i, rows[i]);
            std::vector<std::vector<double>> answers;
            for (BandSolver<width>* solver : {&by_block, &by_row, &by_element}) {
                ASSERT_TRUE(solver->factor());
                answers.emplace_back(n);
                for (std::size_t i = 0; i < n; ++i)
                    answers.back()[i] = static_cast<double>(i % 5);
                solver->solve(std::span(answers.back()));
            }
            for (std::size_t i = 0; i < n; ++i) {
                EXPECT_NEAR(answers[0][i], answers[2][i], 1e-14) << n << " " << i;
                EXPECT_NEAR(answers[1][i], answers[2][i], 1e-14) << n << " " << i;
            }
        }
}

TEST(BandSolver, AgreesWithADenseSolver) {
    for (const std::size_t n : {7U, 8U, 9U, 12U, 50U}) {
        compare<3>(n, true);
        compare<3>(n, false);
        compare<1>(n, true);
        compare<1>(n, false);
    }
    for (const std::size_t n : {9U, 10U, 11U, 12U, 13U, 14U, 15U, 16U, 17U, 60U})
        for (const bool cyclic : {false, true})
            compare<4>(n, cyclic);
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
