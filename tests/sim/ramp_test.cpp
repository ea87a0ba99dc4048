// SPDX-License-Identifier: Apache-2.0
#include "sim/ramp.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cmm::sim {
namespace {

TEST(Ramp, LongWayIsATrapezoid) {
    const Ramp ramp(100.0, 0.0, 0.0, 50.0, 100.0);  // 0.5 s and 12.5 mm for each ramp, 75 mm even
    EXPECT_NEAR(ramp.duration(), 0.5 + 1.5 + 0.5, 1e-12);
    EXPECT_NEAR(ramp.distance_at(0.5), 12.5, 1e-12);
    EXPECT_NEAR(ramp.speed_at(1.0), 50.0, 1e-12);
    EXPECT_NEAR(ramp.distance_at(2.5), 100.0, 1e-12);
    EXPECT_NEAR(ramp.speed_at(2.4), 10.0, 1e-9);
}

TEST(Ramp, ShortWayNeverReachesTheSpeed) {
    const Ramp ramp(1.0, 0.0, 0.0, 50.0, 100.0);
    EXPECT_NEAR(ramp.duration(), 2.0 * std::sqrt(1.0 / 100.0), 1e-12);
    EXPECT_NEAR(ramp.speed_at(ramp.duration() / 2), 10.0, 1e-9);
}

TEST(Ramp, TimeIsTheInverseOfDistance) {
    const Ramp ramp(20.0, 5.0, 8.0, 30.0, 200.0);
    for (double way = 0.0; way <= 20.0; way += 0.37)
        EXPECT_NEAR(ramp.distance_at(ramp.time_at(way)), way, 1e-9);
    EXPECT_EQ(ramp.speed_at(0.0), 5.0);
    EXPECT_NEAR(ramp.speed_at(ramp.duration()), 8.0, 1e-9);
}

TEST(Ramp, SpeedIsTheRateOfDistanceAndKeepsTheAcceleration) {
    const Ramp ramp(20.0, 5.0, 8.0, 30.0, 200.0);
    constexpr double dt = 1e-5;
    for (double t = dt; t + dt < ramp.duration(); t += 1e-3) {
        const double speed = (ramp.distance_at(t + dt) - ramp.distance_at(t - dt)) / (2 * dt);
        EXPECT_NEAR(speed, ramp.speed_at(t), 1e-2);
        EXPECT_LE(std::abs(ramp.speed_at(t + dt) - ramp.speed_at(t)) / dt, 200.0 + 1e-6);
    }
}

TEST(Ramp, NoWayTakesNoTime) {
    EXPECT_EQ(Ramp(0.0, 0.0, 0.0, 10.0, 100.0).duration(), 0.0);
    EXPECT_EQ(Ramp().distance_at(1.0), 0.0);
}

}  // namespace
}  // namespace cmm::sim
