// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset_spline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fitting/offset.hpp"
#include "support/shapes.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

using truth::ellipse, truth::through, truth::polygon, truth::Distance;

double worst_error(const PiecewiseCubic& curve, const PiecewiseCubic& source, double distance, int count) {
    const Distance to_source(source);
    double worst = 0.0;
    for (int i = 0; i < count; ++i) {
        const Vec2 p = curve.jet(curve.period() * (i + 0.37) / count).position;
        worst = std::max(worst, std::abs(to_source.of(p) - std::abs(distance)));
    }
    return worst;
}

/// Blade-like: thick round nose, thin tail, cambered; 90 pieces.
PiecewiseCubic airfoil() {
    return through(
        [](double t) {
            const double x = std::cos(t);
            return Vec2(30 * x, (3.0 - 1.2 * x) * std::sin(t) + 5.0 * (1 - x * x));
        },
        90);
}

TEST(OffsetSpline, StaysWithinItsBoundAndTheBoundWithinTheTolerance) {
    for (const PiecewiseCubic& source : {ellipse(30, 4, 120), ellipse(6, 4, 60), airfoil()}) {
        for (const double distance : {0.5, 2.0, -0.3, 30.0}) {
            for (const double tolerance : {1e-3, 1e-4, 1e-6}) {
                const auto offset = offset_spline(source, distance, tolerance);
                ASSERT_GT(offset.curve.spans(), 0U);
                EXPECT_LE(offset.error_mm, tolerance);
                const double true_error = worst_error(offset.curve, source, distance, 700);
                EXPECT_LE(true_error, offset.error_mm + 1e-11);
                EXPECT_GT(true_error, 0.1 * offset.error_mm) << "the bound is not idle";
            }
        }
    }
}

TEST(OffsetSpline, IsSmoothWhereTheSourceIs) {
    const auto offset = offset_spline(airfoil(), 1.0, 1e-4).curve;
    for (std::size_t k = 0; k < offset.spans(); ++k) {
        const Jet end = offset.jet_in(k, offset.breaks()[k + 1]);
        const auto& next = offset.pieces()[(k + 1) % offset.spans()];
        EXPECT_NEAR((end.position - next[0]).norm(), 0.0, 1e-12);
        EXPECT_NEAR(turn_angle(end.d1, next[1]), 0.0, 1e-10);
    }
}

TEST(OffsetSpline, EndsInTheCornersThatTrimmingLeaves) {
    const auto source = ellipse(6, 2, 200);
    const auto exact = offset_inwards(source, 1.2, 100);
    const auto offset = offset_spline(source, -1.2, 1e-4);
    ASSERT_EQ(exact.corners.size(), 2U);
    EXPECT_LE(offset.error_mm, 1e-4);
    EXPECT_LE(worst_error(offset.curve, source, 1.2, 1500), 1e-4);
    for (const auto& corner : exact.corners) {
        double nearest = 1e300;
        for (const auto& piece : offset.curve.pieces())
            nearest = std::min(nearest, (piece[0] - corner.position).norm());
        EXPECT_LT(nearest, 1e-12);
    }
    EXPECT_EQ(offset_spline(source, -2.1, 1e-4).curve.spans(), 0U);
}

TEST(OffsetSpline, RoundsCornersOfTheSourceByArcs) {
    const auto square = polygon({{0, 0}, {4, 0}, {4, 4}, {0, 4}});
    const auto offset = offset_spline(square, 1.0, 1e-5);
    EXPECT_LE(offset.error_mm, 1e-5);
    for (int i = 0; i < 4000; ++i) {
        const Vec2 p = offset.curve.jet(offset.curve.period() * i / 4000.0).position;
        const Vec2 outside = ((p - Vec2(2, 2)).cwiseAbs() - Vec2(2, 2)).cwiseMax(0.0);
        EXPECT_NEAR(outside.norm(), 1.0, 1.01e-5);
    }
}

}  // namespace
}  // namespace cmm::fitting
