// SPDX-License-Identifier: Apache-2.0
#include "acquisition/touch_way.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cmm::acquisition {
namespace {

using Eigen::Vector3d;

drivers::PathPoint place(double x, double y, double angle_rad) {
    drivers::PathPoint made;
    made.centre_mm = {x, y, 10.0};
    made.normal = {std::cos(angle_rad), std::sin(angle_rad), 0.0};
    return made;
}

/// Places on a circle of 20 mm, a millimetre apart.
std::vector<drivers::PathPoint> circle(std::size_t count) {
    std::vector<drivers::PathPoint> places;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = 0.05 * static_cast<double>(i);
        places.push_back(place(20.0 * std::cos(angle), 20.0 * std::sin(angle), angle));
    }
    return places;
}

/// Contacts at these places, some deeper than expected and some less.
std::vector<RecordedPoint> contacts(const std::vector<drivers::PathPoint>& places,
                                    const std::vector<std::size_t>& touched) {
    std::vector<RecordedPoint> points;
    for (const std::size_t index : touched) {
        const double deep_mm = 0.3 * std::sin(static_cast<double>(index));
        points.emplace_back();
        points.back().centre_mm = places.at(index).centre_mm - deep_mm * places.at(index).normal;
    }
    return points;
}

TEST(TouchWay, StraightWhereTheNormalsAgree) {
    const auto way = way_between(place(0.0, 0.0, 0.1), place(0.0, 0.4, 0.15), 1.0);
    ASSERT_EQ(way.size(), 1U);
    EXPECT_TRUE(way[0].isApprox(Vector3d(std::cos(0.15), 0.4 + std::sin(0.15), 10.0), 1e-12));
}

TEST(TouchWay, RoundAnEdgeItKeepsItsDistance) {
    // Both sides of a plate without thickness: the ball centre runs on a half circle of 1 mm about its end.
    for (const double turn : {1.0, 2.0, 3.141592653589793, -2.5}) {
        const auto from = place(0.0, 0.0, 0.0);
        const auto to = place(0.0, 0.0, turn);
        const auto way = way_between(from, to, 2.0);
        EXPECT_GE(way.size(), static_cast<std::size_t>(std::abs(turn) / 0.53));
        Vector3d before = from.centre_mm + 2.0 * from.normal;
        for (const auto& point : way) {
            EXPECT_NEAR((point - from.centre_mm).norm(), 2.0, 1e-9);
            EXPECT_GT((0.5 * (before + point) - from.centre_mm).norm(), 1.9);
            before = point;
        }
        EXPECT_TRUE(way.back().isApprox(to.centre_mm + 2.0 * to.normal, 1e-9));
    }
}

TEST(TouchWay, AHollowThatIsTooNarrowForTheApproachIsFound) {
    // A horseshoe: in its hollow of 3 mm the centre of a ball of 1 mm runs 2 mm from the middle.
    const double pi = std::acos(-1.0);
    const auto at = [](double radius, double angle) {
        return fitting::Vec2(radius * std::cos(angle), radius * std::sin(angle));
    };
    std::vector<fitting::Vec2> horseshoe;
    for (int i = 0; i <= 100; ++i)
        horseshoe.push_back(at(5.0, 0.5 + (2.0 * pi - 1.0) * i / 100.0));
    for (int i = 100; i >= 0; --i)
        horseshoe.push_back(at(3.0, 0.5 + (2.0 * pi - 1.0) * i / 100.0));
    std::vector<drivers::PathPoint> places;
    for (double angle = 1.5 * pi; angle > 0.5 * pi; angle -= 0.1)
        places.push_back(place(at(2.0, angle).x(), at(2.0, angle).y(), angle + pi));
    const auto outline = fitting::ClosedCurve::through(horseshoe).value();
    EXPECT_FALSE(blocked_place(places, outline, 1.0, 1.0));
    EXPECT_FALSE(blocked_place(places, outline, 1.0, 2.0));
    EXPECT_EQ(blocked_place(places, outline, 1.0, 3.5), 0U);
}

TEST(TouchWay, TheNextPlaceIsBehindTheLastContact) {
    const auto places = circle(60);
    EXPECT_EQ(next_place(places, {}), 0U);
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_EQ(next_place(places, contacts(places, all)), i);
        all.push_back(i);
    }
    EXPECT_EQ(next_place(places, contacts(places, all)), places.size());
}

TEST(TouchWay, PlacesWithoutContactCountAsTouched) {
    const auto places = circle(60);
    EXPECT_EQ(next_place(places, contacts(places, {0, 1, 4, 5, 11})), 12U);
    EXPECT_EQ(next_place(places, contacts(places, {most_missed_places})), most_missed_places + 1);
}

TEST(TouchWay, MoreContactsThanPlacesLeaveNone) {
    const auto places = circle(3);
    const auto many = contacts(circle(10), {0, 1, 2, 3, 4, 5});
    EXPECT_EQ(next_place(places, many), places.size());
}

}  // namespace
}  // namespace cmm::acquisition
