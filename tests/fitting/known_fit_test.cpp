// SPDX-License-Identifier: Apache-2.0
#include "fitting/known_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/rng.hpp"
#include "support/airfoil.hpp"

namespace cmm::fitting {
namespace {

using airfoil::Airfoil;
using Spacing = Airfoil::Spacing;

/// A curve smoothed with joints that are known; its parameters count from `begin_t`.
core::Result<SmoothCurve> with_known_joints(const SmoothCurve& smooth, std::span<const double> places, double begin_t) {
    KnownShape shape{own_breaks(smooth, begin_t), {}, {}};
    for (const double t : places)
        shape.joints.push_back({t - begin_t, 0.1, 0.02});
    KnownFit fit(smooth, begin_t);
    if (auto status = fit.fit(shape); !status) return tl::unexpected(status.error());
    return std::move(fit).finish();
}

/// What is known may change: a joint more, one less.
TEST(KnownFit, AnotherNumberOfJointsBeginsAnew) {
    const auto points = Airfoil(1.0).scan(600, Spacing::even, 1e-3, 3);
    const auto smooth = smooth_closed(points);
    ASSERT_TRUE(smooth);
    const double begin_t = smooth->curve.breaks().front(), period = smooth->curve.period();
    const KnownJoint first{0.3 * period, 0.1, 0.02}, second{0.6 * period, 0.1, 0.02};
    const KnownShape two{own_breaks(*smooth, begin_t), {first, second}, {}};
    const KnownShape one{two.breaks, {first}, {}};
    KnownFit changed(*smooth, begin_t), fresh(*smooth, begin_t);
    ASSERT_TRUE(changed.fit(two));
    ASSERT_EQ(changed.joints().size(), 2U);
    ASSERT_TRUE(changed.fit(one));
    ASSERT_TRUE(fresh.fit(one));
    ASSERT_EQ(changed.joints().size(), 1U);
    EXPECT_NEAR(changed.joints()[0].t, fresh.joints()[0].t, 0.02);
    EXPECT_TRUE(changed.fit(two));
    EXPECT_EQ(changed.joints().size(), 2U);
}

TEST(KnownFit, JointsNeedRoom) {
    const auto points = Airfoil(1.0).scan(600, Spacing::even, 1e-3, 3);
    const auto smooth = smooth_closed(points);
    ASSERT_TRUE(smooth);
    const auto& breaks = smooth->curve.breaks();
    const std::size_t middle = breaks.size() / 2;
    const auto with = [&](const std::vector<double>& places) {
        return with_known_joints(*smooth, places, breaks.front());
    };
    const auto one = with({breaks[middle] + 0.01});
    ASSERT_TRUE(one);
    ASSERT_EQ(one->joints.size(), 1U);
    EXPECT_NEAR(one->joints[0].t, breaks[middle], 0.06);
    EXPECT_EQ(one->parameter.size(), points.size());
    for (const double t : {breaks.front(), 0.5 * (breaks[0] + breaks[1]),
                           0.5 * (breaks.back() + breaks[breaks.size() - 2]), std::nan("")})
        EXPECT_FALSE(with({t})) << "at " << t << ", where the curve begins";
    EXPECT_FALSE(with({breaks[middle], breaks[middle] + 0.001})) << "two in one place";
    // It may begin elsewhere.
    const double begin_t = breaks[middle] - 20.0, period = breaks.back() - breaks.front();
    const auto turned = with_known_joints(*smooth, std::vector{breaks[middle] + 0.01}, begin_t);
    ASSERT_TRUE(turned);
    EXPECT_EQ(turned->curve.breaks().front(), 0.0);
    EXPECT_NEAR(turned->joints[0].t, 20.0, 0.06);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double apart = turned->parameter[i] + begin_t - one->parameter[i];
        EXPECT_NEAR(std::remainder(apart, period), 0.0, 1e-3);
        EXPECT_NEAR(turned->residual[i], one->residual[i], 1e-3);
    }
    core::Rng rng(4);
    int fitted = 0;
    for (int k = 0; k < 100; ++k) {
        std::vector<double> places(1 + rng.below(5));
        for (double& t : places)
            t = rng.uniform(breaks.front(), breaks.back());
        std::sort(places.begin(), places.end());
        const auto curve = with(places);
        if (!curve) continue;
        ++fitted;
        EXPECT_NEAR(curve->sigma_mm, 1e-3, 0.3e-3);
    }
    EXPECT_GT(fitted, 50);
}

}  // namespace
}  // namespace cmm::fitting
