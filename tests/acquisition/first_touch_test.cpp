// SPDX-License-Identifier: Apache-2.0
#include "acquisition/first_touch.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct FirstTouchTest : ::testing::Test {
    FirstTouchTest() {
        path.z_mm = 12.0;
        path.start_mm = Vector2d(-50.0, 0.0);
        path.toward_mm = Vector2d(0.0, 0.0);
        part.scan.box_mm = std::array<double, 4>{-20.0, -20.0, 20.0, 20.0};
    }
    PlannedPath path;
    PartFile part;
};

TEST_F(FirstTouchTest, LinesRunThroughTheBoxOnEitherSideOfTheFirst) {
    const auto lines = touch_lines(path, part, std::nullopt);
    const std::vector<double> aside{0, 5, -5, 10, -10, 15, -15, 20, -20};
    ASSERT_EQ(lines.size(), aside.size());
    for (std::size_t i = 0; i < lines.size(); ++i) {
        EXPECT_TRUE(lines[i].from.isApprox(Vector3d(-50.0, aside[i], 12.0))) << i;
        EXPECT_TRUE(lines[i].to.isApprox(Vector3d(20.0, aside[i], 12.0))) << i;
    }
}

TEST_F(FirstTouchTest, SlantedLinesEndWhereTheyLeaveTheBox) {
    path.start_mm = Vector2d(-30.0, -30.0);
    const auto lines = touch_lines(path, part, std::nullopt);
    ASSERT_FALSE(lines.empty());
    EXPECT_TRUE(lines[0].to.isApprox(Vector3d(20.0, 20.0, 12.0)));
    for (const auto& line : lines) {
        const Vector3d way = (line.to - line.from).normalized();
        EXPECT_NEAR(way.x(), std::sqrt(0.5), 1e-12);
        EXPECT_NEAR(way.y(), std::sqrt(0.5), 1e-12);
        EXPECT_NEAR(std::max(line.to.x(), line.to.y()), 20.0, 1e-9);
    }
}

TEST_F(FirstTouchTest, TheSectionBeforeSaysWhereToLookFirst) {
    const Entry before{{3.0, 4.0, 10.0}, Vector2d(0.0, 1.0)};
    const auto lines = touch_lines(path, part, before);
    ASSERT_EQ(lines.size(), 10U);
    const double far = 2.0 * part.scan.clearance_mm + part.scan.search_mm;
    EXPECT_TRUE(lines[0].from.isApprox(Vector3d(3.0, 4.0 + far, 12.0)));
    EXPECT_TRUE(lines[0].to.isApprox(Vector3d(3.0, 4.0 - far, 12.0)));
    EXPECT_TRUE(lines[1].from.isApprox(Vector3d(-50.0, 0.0, 12.0)));
}

TEST_F(FirstTouchTest, NormalFromOneTwoOrThreeContacts) {
    const Vector2d first(5.0, 7.0);
    for (const double heading : {0.0, 1.0, 2.5, -2.0}) {
        const Vector2d direction(std::cos(heading), std::sin(heading));
        const Vector2d left(-direction.y(), direction.x());
        EXPECT_TRUE(outward_normal(first, {}, direction).isApprox(-direction));
        for (const double lean : {-1.0, -0.3, 0.0, 0.8}) {
            // A flat surface that leans by this angle to the touch.
            const Vector2d surface = std::cos(lean) * left + std::sin(lean) * direction;
            const Vector2d normal = -std::cos(lean) * direction + std::sin(lean) * left;
            const std::vector<Vector2d> two{first + 0.3 / std::cos(lean) * surface,
                                            first - 0.3 / std::cos(lean) * surface};
            EXPECT_TRUE(outward_normal(first, two, direction).isApprox(normal)) << heading << " " << lean;
            const std::span<const Vector2d> one(two.data(), 1);
            EXPECT_TRUE(outward_normal(first, one, direction).isApprox(normal)) << heading << " " << lean;
            // The other contact fell over an edge: it does not count.
            const std::vector<Vector2d> over{two[0], first - 0.3 * left + 1.5 * direction};
            EXPECT_TRUE(outward_normal(first, over, direction).isApprox(normal)) << heading << " " << lean;
        }
    }
}

TEST_F(FirstTouchTest, AContactAtTheSamePlaceSaysNothing) {
    const std::vector<Vector2d> same{Vector2d(1.0, 1.0)};
    EXPECT_TRUE(outward_normal(same[0], same, Vector2d::UnitX()).isApprox(Vector2d(-1.0, 0.0)));
}

TEST_F(FirstTouchTest, WithoutABoxTheTravelIsTheBox) {
    drivers::Capabilities machine;
    machine.limit_min_mm = {-100.0, -80.0, 0.0};
    machine.limit_max_mm = {100.0, 60.0, 90.0};
    const auto given = part.scan.box_mm;
    bound_by_travel(part, machine);
    EXPECT_EQ(part.scan.box_mm, given);
    part.scan.box_mm.reset();
    bound_by_travel(part, machine);
    ASSERT_TRUE(part.scan.box_mm);
    const double room =
        2.0 * (part.scan.clearance_mm + part.scan.approach_mm + part.stylus.radius_mm) + 1.0;  // as documented
    EXPECT_EQ(*part.scan.box_mm, (std::array<double, 4>{-100.0 + room, -80.0 + room, 100.0 - room, 60.0 - room}));
}

TEST_F(FirstTouchTest, EntryOfAMeasuredSection) {
    std::vector<Vector3d> circle;  // counter-clockwise from (10, 0)
    for (int i = 0; i < 20; ++i)
        circle.emplace_back(10.0 * std::cos(0.02 * i), 10.0 * std::sin(0.02 * i), 4.0);
    const auto entry = entry_of(circle);
    EXPECT_EQ(entry.contact_mm, circle.front());
    EXPECT_GT(entry.outward.x(), 0.99);
    EXPECT_NEAR(entry.outward.norm(), 1.0, 1e-12);
    EXPECT_EQ(entry_of(std::span(circle).first(1)).contact_mm, circle.front());
    EXPECT_NEAR(entry_of(std::span(circle).first(2)).outward.x(), 1.0, 1e-3);
}

}  // namespace
}  // namespace cmm::acquisition
