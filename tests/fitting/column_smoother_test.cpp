// SPDX-License-Identifier: Apache-2.0
#include "fitting/column_smoother.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/rng.hpp"
#include "fitting/row_columns.hpp"

namespace cmm::fitting {
namespace {

std::vector<double> uneven_rows(std::size_t count) {
    std::vector<double> z;
    for (std::size_t k = 0; k < count; ++k)
        z.push_back(2.0 * double(k) + 0.3 * std::sin(3.0 * double(k)));
    return z;
}

TEST(ColumnSmoother, CubicsCostNothing) {
    const auto z = uneven_rows(12);
    const auto cubic = [](double v) { return Vec3(1 + v - 0.02 * v * v * v, v * v, v); };
    std::vector<Vec3> column, controls;
    for (const double v : z)
        column.push_back(cubic(v));
    ColumnSmoother smoother(z, 1.0);
    for (const double weight : {1e-4, 1.0, 1e5}) {
        ASSERT_TRUE(smoother.set_weight(weight));
        smoother.solve(column, controls);
        for (std::size_t k = 0; k < z.size(); ++k)
            EXPECT_LT((smoother.at_row(k, controls) - column[k]).norm(), 1e-6);
        const auto curve = *BSpline<3>::make(3, smoother.axis().knots(), controls, false);
        EXPECT_LT((curve.position(z.back() + 1.0) - cubic(z.back() + 1.0)).norm(), 1e-5) << "beyond the rows";
    }
}

TEST(ColumnSmoother, FreedomIsTheSumOfLeveragesAndTakesNoiseAway) {
    const auto z = uneven_rows(25);
    ColumnSmoother smoother(z, 0.0);
    double last = 26.0;
    for (const double weight : {1e-6, 1e-2, 1.0, 1e2, 1e6}) {
        ASSERT_TRUE(smoother.set_weight(weight));
        EXPECT_LT(smoother.freedom(), last);
        last = smoother.freedom();
        core::Rng rng(1);
        double squares = 0.0;
        std::vector<Vec3> column(z.size()), controls;
        for (int trial = 0; trial < 2000; ++trial) {
            for (Vec3& p : column)
                p = {rng.normal(), 0, 0};
            smoother.solve(column, controls);
            for (std::size_t k = 0; k < z.size(); ++k)
                squares += std::pow(smoother.at_row(k, controls).x(), 2);
        }
        EXPECT_LT(squares / 2000, smoother.freedom() * 1.05) << "a smoother takes more from the variance";
        EXPECT_GT(squares / 2000, 0.5 * smoother.freedom());
    }
    EXPECT_NEAR(last, 4.0, 0.05) << "a cubic is left";
}

TEST(ColumnSmoother, FourColumnsSideBySideAreSmoothedAsEachByItself) {
    const auto z = uneven_rows(9);
    ColumnSmoother smoother(z, 0.0);
    ASSERT_TRUE(smoother.set_weight(0.3));
    core::Rng rng(4);
    RowColumns columns;
    columns.reset(6, z.size());
    ASSERT_EQ(columns.fours().size(), 2U);
    for (std::size_t i = 0; i < columns.size(); ++i)
        for (std::size_t k = 0; k < z.size(); ++k)
            columns.set(i, k, {rng.normal(), rng.normal()});
    std::vector<RowColumns::Four> together;
    for (std::size_t i = 0; i < columns.size(); ++i) {
        std::vector<Vec2> column, alone;
        for (std::size_t k = 0; k < z.size(); ++k)
            column.push_back(columns.at(i, k));
        smoother.solve(column, alone);
        smoother.solve(columns.fours()[i / 4], together);
        for (std::size_t k = 0; k < z.size(); ++k) {
            const RowColumns::Four at_row = smoother.at_row(k, together);
            const auto lane = static_cast<Eigen::Index>(i % 4);
            EXPECT_LT((smoother.at_row(k, alone) - Vec2(at_row(lane, 0), at_row(lane, 1))).norm(), 1e-14)
                << i << " " << k;
            EXPECT_EQ(columns.fours()[1][k](2, 0), 0.0) << "a spare lane";
        }
    }
}

TEST(ColumnSmoother, TwoRowsMakeALine) {
    const std::vector<double> z{1, 3};
    ColumnSmoother smoother(z, 0.5);
    ASSERT_TRUE(smoother.set_weight(1.0));
    std::vector<Vec3> controls;
    smoother.solve<Vec3>({{0, 0, 1}, {4, 2, 3}}, controls);
    const auto curve = *BSpline<3>::make(3, smoother.axis().knots(), controls, false);
    EXPECT_LT((curve.position(2.0) - Vec3(2, 1, 2)).norm(), 1e-4);
    EXPECT_LT((curve.position(3.5) - Vec3(5, 2.5, 3.5)).norm(), 1e-3);
}

}  // namespace
}  // namespace cmm::fitting
