// SPDX-License-Identifier: Apache-2.0
#include "fitting/arc_length.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace cmm::fitting {
namespace {

/// y = x^2 / 2 over x in [from, to]: its arc length is (x sqrt(1 + x^2) + asinh x) / 2.
double parabola_length(double x) {
    return 0.5 * (x * std::sqrt(1.0 + x * x) + std::asinh(x));
}

PiecewiseCubic parabola(const std::vector<double>& breaks) {
    std::vector<PiecewiseCubic::Piece> pieces;
    for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
        const double x = breaks[k];
        pieces.push_back({Vec2(x, 0.5 * x * x), Vec2(1.0, x), Vec2(0.0, 0.5), Vec2(0.0, 0.0)});
    }
    return {breaks, pieces, false};
}

TEST(ArcLength, OfAParabolaToTwelveDigits) {
    // The second piece turns by 170 degrees.
    const PiecewiseCubic curve = parabola({-30.0, -12.0, 11.0, 11.5, 40.0});
    const ArcLength arc(curve);
    const double total = parabola_length(40.0) + parabola_length(30.0);
    EXPECT_NEAR(arc.total(), total, 1e-12 * total);
    for (double x = -30.0; x <= 40.0; x += 0.37) {
        double t = x;
        const std::size_t span = curve.span_of(t);
        const double truth = parabola_length(x) + parabola_length(30.0);
        EXPECT_NEAR(arc.at(curve, {span, t}), truth, 1e-12 * total) << x;
        const CurvePlace place = arc.place(curve, truth);
        EXPECT_NEAR(place.t, x, 1e-12 * total) << x;
        EXPECT_GE(place.t, curve.breaks()[place.span]);
        EXPECT_LE(place.t, curve.breaks()[place.span + 1]);
    }
}

TEST(ArcLength, EndsAndBeyond) {
    const PiecewiseCubic curve = parabola({0.0, 1.0, 2.0});
    const ArcLength arc(curve);
    EXPECT_EQ(arc.place(curve, 0.0).t, 0.0);
    EXPECT_NEAR(arc.place(curve, arc.total()).t, 2.0, 1e-14);
    EXPECT_EQ(arc.place(curve, -3.0).t, 0.0);
    EXPECT_NEAR(arc.place(curve, 1e9).t, 2.0, 1e-14);
    EXPECT_TRUE(std::isnan(arc.place(curve, std::nan("")).t));
    EXPECT_EQ(ArcLength().total(), 0.0);
}

TEST(ArcLength, OfACuspTheLimitIsAMillionth) {
    // x = t^2, y = t^3 stops at t = 0: length (1/27) ((4 + 9 t^2)^(3/2) - 8) on each side.
    const PiecewiseCubic curve({-1.0, 1.0}, {{Vec2(1, -1), Vec2(-2, 3), Vec2(1, -3), Vec2(0, 1)}}, false);
    const double truth = 2.0 * (std::pow(13.0, 1.5) - 8.0) / 27.0;
    EXPECT_NEAR(ArcLength(curve).total(), truth, 1e-6 * truth);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(std::isnan(
        ArcLength(PiecewiseCubic({0, 1}, {{Vec2(nan, 0), Vec2(nan, 1), Vec2(0, 0), Vec2(0, 0)}}, false)).total()));
}

}  // namespace
}  // namespace cmm::fitting
