// SPDX-License-Identifier: Apache-2.0
#include "sim/scan_path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace cmm::sim {
namespace {

using Append = ScanPath::Append;

std::vector<PathPoint> line(int count, double step, double speed) {
    std::vector<PathPoint> points;
    for (int i = 0; i < count; ++i)
        points.push_back({{i * step, 0, 0}, Eigen::Vector3d::UnitY(), speed, true, false});
    return points;
}

ScanPath started(std::size_t capacity = 1000, double tick_s = 1e-3) {
    ScanPath path;
    path.begin(3, capacity, PathLimits{100.0, 1000.0, tick_s});
    return path;
}

TEST(ScanPath, RepeatsChangeNothingAndGapsAreRefused) {
    ScanPath path = started();
    const auto points = line(10, 1.0, 10.0);
    const std::span<const PathPoint> all(points);
    EXPECT_EQ(path.append(0, all.first(4)), Append::taken);
    EXPECT_EQ(path.append(0, all.first(4)), Append::repeated);
    EXPECT_EQ(path.append(2, all.subspan(2, 2)), Append::repeated);
    EXPECT_EQ(path.received(), 4U);
    EXPECT_EQ(path.append(5, all.subspan(5, 2)), Append::invalid);
    EXPECT_EQ(path.append(2, all.subspan(2, 4)), Append::invalid);
    EXPECT_EQ(path.append(4, {}), Append::invalid);
    EXPECT_EQ(path.append(4, all.subspan(4)), Append::taken);
    EXPECT_EQ(path.received(), 10U);
}

TEST(ScanPath, NothingFollowsTheLastPoint) {
    ScanPath path = started();
    auto points = line(4, 1.0, 10.0);
    points[1].last = true;
    EXPECT_EQ(path.append(0, points), Append::invalid);
    EXPECT_EQ(path.append(0, std::span<const PathPoint>(points).first(2)), Append::taken);
    EXPECT_EQ(path.append(2, std::span<const PathPoint>(points).subspan(2)), Append::invalid);
}

TEST(ScanPath, CapacityCountsPointsAheadOfTheProbe) {
    ScanPath path = started(10);
    const auto points = line(20, 1.0, 10.0);
    const std::span<const PathPoint> all(points);
    EXPECT_EQ(path.append(0, all.first(10)), Append::taken);
    EXPECT_EQ(path.append(10, all.subspan(10, 3)), Append::full);
    for (std::uint32_t i = 0; i < 3; ++i)
        path.pass(i);
    EXPECT_EQ(path.append(10, all.subspan(10, 3)), Append::taken);
    EXPECT_FALSE(path.has(0));
    EXPECT_TRUE(path.has(2));
    EXPECT_EQ(path.append(0, all.first(10)), Append::repeated) << "points that are forgotten still count as received";
}

TEST(ScanPath, SpeedNeverExceedsTheTick) {
    ScanPath path = started(1000, 0.01);
    ASSERT_EQ(path.append(0, line(10, 0.05, 50.0)), Append::taken);
    EXPECT_NEAR(path.segment_speed(3), 0.05 / 0.01, 1e-12);
    auto silent = line(10, 0.05, 50.0);
    for (PathPoint& point : silent)
        point.record = false;
    ScanPath other = started(1000, 0.01);
    ASSERT_EQ(other.append(0, silent), Append::taken);
    EXPECT_EQ(other.segment_speed(3), 50.0) << "a point that records nothing needs no tick";
}

TEST(ScanPath, LookAheadStopsAtTheEndOfWhatIsKnown) {
    ScanPath path = started();
    ASSERT_EQ(path.append(0, line(11, 1.0, 90.0)), Append::taken);
    EXPECT_EQ(path.point_speed(10), 0.0);
    EXPECT_NEAR(path.point_speed(9), std::sqrt(2.0 * 1000.0 * 1.0), 1e-9);
    EXPECT_NEAR(path.point_speed(7), std::sqrt(2.0 * 1000.0 * 3.0), 1e-9);
    EXPECT_EQ(path.point_speed(2), 90.0);
}

TEST(ScanPath, CornersKeepTheCentripetalAcceleration) {
    ScanPath path = started();
    std::vector<PathPoint> points;
    constexpr double radius = 0.5;
    for (int i = 0; i < 400; ++i)
        points.push_back({{radius * std::cos(i * 0.1), radius * std::sin(i * 0.1), 0},
                          {std::cos(i * 0.1), std::sin(i * 0.1), 0},
                          90.0,
                          true,
                          false});
    ASSERT_EQ(path.append(0, points), Append::taken);
    EXPECT_NEAR(path.point_speed(50), std::sqrt(1000.0 * radius), 1e-6);
    EXPECT_NEAR(path.turning_per_mm(50), 0.1 / (2 * radius * std::sin(0.05)), 1e-9);
    EXPECT_EQ(path.turning_per_mm(0), 0.0);
}

TEST(ScanPath, AReversalIsAHalt) {
    ScanPath path = started();
    auto points = line(3, 1.0, 50.0);
    points[2].position = points[0].position;
    ASSERT_EQ(path.append(0, points), Append::taken);
    EXPECT_EQ(path.point_speed(1), 0.0);
}

}  // namespace
}  // namespace cmm::sim
