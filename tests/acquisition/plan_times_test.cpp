// SPDX-License-Identifier: Apache-2.0
#include "acquisition/plan_times.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/acquisition/six_point_blade.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector3d;

TEST(PlanTimes, OfTouchesAreThoseOfTheMotions) {
    Plan plan;
    plan.approach_mm = 1.5;
    plan.approach_speed_mm_s = 10.0;
    plan.paths.resize(2);
    for (const double y : {0.0, 5.0, 25.0})
        plan.paths[0].points.push_back({{0.0, y, 10.0}, Vector3d::UnitX(), 1.0, true});
    plan.paths[0].duration_s = 2.0;
    plan.duration_s = 6.0;  // 4 s of travel
    const auto times = plan_times(plan, true);
    ASSERT_EQ(times.sections_s.size(), 2U);
    // Each place: 1.5 mm at 2 mm/s and back at 5 mm/s; 25 mm from the first to the last.
    EXPECT_NEAR(times.sections_s[0], 3.0 * (0.75 + 0.3) + 2.5, 1e-9);
    EXPECT_EQ(times.sections_s[1], 0.0);
    EXPECT_EQ(times.alignment_s, 0.0);
    EXPECT_NEAR(times.total_s, 4.0 + times.sections_s[0], 1e-9);
    plan.approach_speed_mm_s = 1.0;
    EXPECT_NEAR(plan_times(plan, true).sections_s[0], 3.0 * (1.5 + 0.3) + 25.0, 1e-9);
    EXPECT_EQ(plan_times(plan, false).sections_s[0], 2.0);
    EXPECT_EQ(plan_times(plan, false).total_s, 6.0);
}

TEST(PlanTimes, TheDatumPointsAreTouchedThreeTimesAndTakeTheirWays) {
    auto plan = SessionPart(session_part_text() + datum_table()).plan;
    const auto plain = plan_times(SessionPart().plan, false), aligned = plan_times(plan, false);
    EXPECT_GT(aligned.alignment_s, 0.0);
    EXPECT_NEAR(aligned.total_s, plain.total_s + aligned.alignment_s, 1e-9);
    // Travel that takes no time leaves the touches: once from 3 mm above, twice from 1 mm.
    plan.travel_speed_mm_s = 1e12;
    ASSERT_EQ(plan.approach_mm, 1.0);
    const double touches_s = 6.0 * (3.0 + 2.0 * 1.0) * (1.0 / 2.0 + 1.0 / 5.0);
    const double ways = (plan_times(plan, false).alignment_s - touches_s) / 0.25;
    EXPECT_NEAR(ways, std::round(ways), 1e-6) << "each starts and stops";
    EXPECT_GE(ways, 18.0);
    EXPECT_GT(aligned.alignment_s, plan_times(plan, false).alignment_s + 1.0);
}

}  // namespace
}  // namespace cmm::acquisition
