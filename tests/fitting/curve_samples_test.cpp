// SPDX-License-Identifier: Apache-2.0
#include "fitting/curve_samples.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/rng.hpp"

namespace cmm::fitting {
namespace {

PiecewiseCubic ellipse() {
    std::vector<Vec2> points;
    for (int i = 0; i < 60; ++i) {
        const double a = 2.0 * std::numbers::pi * i / 60.0;
        points.emplace_back(10.0 * std::cos(a), 3.0 * std::sin(a));
    }
    return interpolate_periodic(points, chord_parameters(points, true));
}

void compare(const CurveSamples& samples, std::size_t i, const Jet& jet) {
    EXPECT_LT((Vec2(samples.x[i], samples.y[i]) - jet.position).norm(), 1e-13);
    EXPECT_LT((Vec2(samples.dx[i], samples.dy[i]) - jet.d1).norm(), 1e-13);
    EXPECT_LT((Vec2(samples.ddx[i], samples.ddy[i]) - jet.d2).norm(), 1e-13);
    EXPECT_LT((Vec2(samples.nx[i], samples.ny[i]) - jet.right_normal()).norm(), 1e-14);
    EXPECT_NEAR(samples.curvature[i], jet.curvature(), 1e-13 * (1.0 + std::abs(jet.curvature())));
}

TEST(CurveSamples, AtParametersInAnyOrderAndOverThePeriod) {
    const PiecewiseCubic curve = ellipse();
    core::Rng rng(4);
    std::vector<double> t(curve.breaks());
    for (int i = 0; i < 500; ++i)
        t.push_back(curve.period() * i / 500.0);
    for (int i = 0; i < 500; ++i)
        t.push_back(rng.uniform(-1.0, 2.0) * curve.period());
    CurveSamples samples;
    for (const std::size_t n : {t.size(), std::size_t{3}, std::size_t{0}, t.size()}) {  // columns are used again
        sample_at(curve, std::span(t).first(n), samples);
        ASSERT_EQ(samples.size(), n);
        for (std::size_t i = 0; i < n; ++i)
            compare(samples, i, curve.jet(t[i]));
    }
}

TEST(CurveSamples, AlongTheArcLength) {
    const PiecewiseCubic curve = ellipse();
    const ArcLength arc(curve);
    core::Rng rng(4);
    std::vector<double> s{0.0, arc.total()};
    for (int i = 0; i < 400; ++i)
        s.push_back(arc.total() * (i < 200 ? i / 200.0 : rng.uniform()));
    CurveSamples samples;
    sample_along(curve, arc, s, samples);
    for (std::size_t i = 0; i < s.size(); ++i) {
        const CurvePlace place = arc.place(curve, s[i]);
        compare(samples, i, curve.jet_in(place.span, place.t));
        EXPECT_NEAR(arc.at(curve, place), s[i], 1e-12 * arc.total());
    }
}

TEST(CurveSamples, WhereTheCurveStopsThereIsNoNormal) {
    const PiecewiseCubic cusp({-1.0, 1.0}, {{Vec2(1, -1), Vec2(-2, 3), Vec2(1, -3), Vec2(0, 1)}}, false);
    CurveSamples samples;
    sample_at(cusp, std::vector<double>{0.0, 0.5}, samples);
    EXPECT_EQ(samples.nx[0], 0.0);
    EXPECT_EQ(samples.curvature[0], 0.0);
    compare(samples, 1, cusp.jet(0.5));
}

}  // namespace
}  // namespace cmm::fitting
