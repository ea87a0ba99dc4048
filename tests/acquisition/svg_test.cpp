// SPDX-License-Identifier: Apache-2.0
#include "acquisition/svg.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acquisition/plot_frame.hpp"

namespace cmm::acquisition::svg {
namespace {

TEST(Svg, EscapesWhatWouldBreakThePage) {
    EXPECT_EQ(escape("a<b>&\"'\x01z"), "a&lt;b&gt;&amp;&quot;&#39;z");
    EXPECT_EQ(escape("\u00b5m"), "\u00b5m");
}

TEST(Svg, NumbersAreShort) {
    EXPECT_EQ(number(12.0), "12");
    EXPECT_EQ(number(12.50), "12.5");
    EXPECT_EQ(number(-0.001), "0");
    EXPECT_EQ(number(1.005e3), "1005");
    EXPECT_EQ(number(100), "100");
}

TEST(Svg, ThinningKeepsTheShape) {
    std::vector<Vector2d> straight;
    for (int i = 0; i <= 100; ++i)
        straight.emplace_back(i, 0.5 * i);
    EXPECT_EQ(polyline(straight, false), "M0 0L100 50");
    std::vector<Vector2d> circle;
    for (int i = 0; i < 2400; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 2400;
        circle.emplace_back(100 * std::cos(a), 100 * std::sin(a));
    }
    const auto data = polyline(circle, true);
    const auto kept = static_cast<double>(std::count(data.begin(), data.end(), 'L'));
    // A chord of a circle of 100 px is 0.05 px off at an angle of 2 acos(1 - 0.0005): at least 100 are needed.
    EXPECT_GE(kept, 99);
    EXPECT_LE(kept, 250);
    EXPECT_EQ(data.back(), 'Z');
    EXPECT_EQ(polyline({}, true), "");
}

TEST(Svg, TicksAreRound) {
    const auto t = ticks(-31.4, 31.4, 6);
    ASSERT_GE(t.values.size(), 5U);
    EXPECT_EQ(t.digits, 0);
    for (const double v : t.values)
        EXPECT_NEAR(std::remainder(v, 5.0), 0.0, 1e-9);
    const auto fine = ticks(0.3521, 0.3919, 4);
    EXPECT_GE(fine.digits, 2);
    EXPECT_GE(fine.values.front(), 0.3521);
    EXPECT_LE(fine.values.back(), 0.3919);
    EXPECT_TRUE(ticks(1.0, 1.0, 4).values.empty());
    EXPECT_EQ(round_down(437.0), 200.0);
    EXPECT_EQ(round_down(1000.0), 1000.0);
    EXPECT_NEAR(round_down(0.07), 0.05, 1e-12);
}

TEST(PlotFrame, EqualScalesKeepTheShape) {
    const auto frame = PlotFrame::equal({10, 20}, {200, 100}, {0, 0}, {10, 10});
    EXPECT_NEAR(frame.scale_x(), frame.scale_y(), 1e-12);
    EXPECT_NEAR(frame.scale_x(), 10.0, 1e-12);
    const auto middle = frame.px({5, 5});
    EXPECT_NEAR(middle.x(), 110, 1e-9);
    EXPECT_NEAR(middle.y(), 70, 1e-9);
    EXPECT_LT(frame.px({5, 6}).y(), middle.y()) << "y grows upwards";
}

}  // namespace
}  // namespace cmm::acquisition::svg
