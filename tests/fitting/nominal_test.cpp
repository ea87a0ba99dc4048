// SPDX-License-Identifier: Apache-2.0
#include "fitting/nominal.hpp"

#include <gtest/gtest.h>

#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

TEST(Nominal, FindsEdgesOnSparseRealProfiles) {
    const auto profiles = truth::hannover_profiles();
    if (profiles.empty()) GTEST_SKIP() << "../shared/data/hannover-4ac is absent";
    ASSERT_GE(profiles.size(), 10U);
    for (const auto& points : profiles) {
        const auto nominal = analyse_nominal(points);
        ASSERT_TRUE(nominal) << nominal.error().message;
        double longest = 0.0;
        for (const Vec2& a : points)
            for (const Vec2& b : points)
                longest = std::max(longest, (a - b).norm());
        EXPECT_GT((nominal->le_point() - nominal->te_point()).norm(), 0.98 * longest) << "the edges are the far ends";
        EXPECT_GT(nominal->le_radius_mm(), 0.05);
        EXPECT_LT(nominal->le_radius_mm(), 0.8);
    }
}

TEST(Nominal, ZonesFollowEachOtherCounterClockwise) {
    const auto outline = truth::envelope_blade({});
    std::vector<Vec2> points;
    for (std::size_t i = 0; i < outline.points.size(); i += 60)
        points.push_back(outline.points[i]);
    const auto nominal = analyse_nominal(points);
    ASSERT_TRUE(nominal);
    const ClosedCurve& curve = nominal->curve();
    std::string order;
    for (int k = 0; k < 2000; ++k) {
        const std::string zone(to_string(nominal->zone_at(nominal->le_mm() + curve.length() * k / 2000.0)));
        if (!order.ends_with(zone + " ")) order += zone + " ";
    }
    EXPECT_EQ(order, "le pressure te suction le ");
    EXPECT_NEAR(nominal->le_radius_mm(), 0.6, 0.03);
    EXPECT_NEAR(nominal->te_radius_mm(), 0.3, 0.03);
}

TEST(Nominal, PassesErrorsOn) {
    EXPECT_FALSE(analyse_nominal(std::vector<Vec2>{{0, 0}, {1, 0}}));
}

}  // namespace
}  // namespace cmm::fitting
