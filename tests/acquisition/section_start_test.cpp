// SPDX-License-Identifier: Apache-2.0
#include "acquisition/section_start.hpp"

#include "tests/acquisition/session_fixture.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<RecordedPoint> recorded(const std::vector<Vector3d>& centres) {
    std::vector<RecordedPoint> points;
    for (const auto& centre : centres) {
        points.emplace_back();
        points.back().centre_mm = centre;
    }
    return points;
}

/// Counter-clockwise on a circle of 20 mm about the origin, ending at angle 0.
std::vector<RecordedPoint> arc(std::size_t count) {
    std::vector<Vector3d> centres;
    for (std::size_t i = 0; i < count; ++i) {
        const double angle = -0.02 * static_cast<double>(count - 1 - i);
        centres.emplace_back(20.0 * std::cos(angle), 20.0 * std::sin(angle), 8.0);
    }
    return recorded(centres);
}

struct SectionStartTest : ::testing::Test {
    SessionPart job;
    SectionSetup setup = job.setup(1);
    const PlannedPath& path = job.plan.paths[1];

    SectionSetup unknown() const {
        SectionSetup bare;
        bare.z_mm = 8.0;
        return bare;
    }
};

TEST_F(SectionStartTest, APlannedSectionStartsAboveItsNextPoint) {
    for (const std::size_t measured : {std::size_t{0}, std::size_t{17}, path.points.size(), path.points.size() + 5}) {
        const auto& next = path.points[std::min(measured, path.points.size() - 1)];
        const auto start = start_of_section(job.plan, path, setup, std::vector<RecordedPoint>(measured));
        EXPECT_TRUE(start.isApprox(next.centre_mm + job.plan.approach_mm * next.normal, 1e-9)) << measured;
    }
}

TEST_F(SectionStartTest, AnUnknownSectionStartsAtTheSearchOrAboveItsLastPoint) {
    PlannedPath search;
    search.z_mm = 8.0;
    search.start_mm = Vector2d(-40.0, 3.0);
    search.toward_mm = Vector2d(0.0, 3.0);
    const auto bare = unknown();
    EXPECT_EQ(start_of_section(job.plan, search, bare, {}), Vector3d(-40.0, 3.0, 8.0));
    EXPECT_EQ(start_of_section(job.plan, search, bare, arc(2)), Vector3d(-40.0, 3.0, 8.0));
    auto measured = arc(30);
    const Vector3d above_last(20.0 + job.plan.approach_mm, 0.0, 8.0);
    EXPECT_NEAR((start_of_section(job.plan, search, bare, measured) - above_last).norm(), 0.0, 0.02);
    // A point in the air after it is not a place to go back to.
    measured.push_back(recorded({{15.0, 0.4, 8.0}}).front());
    measured.back().verdict.reason = fitting::RejectReason::no_contact;
    EXPECT_NEAR((start_of_section(job.plan, search, bare, measured) - above_last).norm(), 0.0, 0.02);
}

TEST_F(SectionStartTest, LastNormalNeedsThreePoints) {
    EXPECT_FALSE(last_normal({}));
    EXPECT_FALSE(last_normal(arc(2)));
    const auto normal = last_normal(arc(10));
    ASSERT_TRUE(normal);
    EXPECT_NEAR((*normal - Vector2d::UnitX()).norm(), 0.0, 0.02);
}

TEST_F(SectionStartTest, TheWayOffAPlannedSectionIsItsNormal) {
    const auto& point = path.points[25];
    const auto way = way_off(setup, {}, point.centre_mm.head<2>(), 2.0);
    ASSERT_TRUE(way);
    EXPECT_NEAR((*way - point.normal.head<2>()).norm(), 0.0, 0.01);
    const Vector2d far = (point.centre_mm + 1.5 * point.normal).head<2>();
    EXPECT_FALSE(way_off(setup, {}, far, 2.0));
}

TEST_F(SectionStartTest, TheWayOffAnUnknownSectionIsThatOfItsLastPoint) {
    const auto bare = unknown();
    const auto measured = arc(30);
    const auto way = way_off(bare, measured, {20.5, 0.0}, 2.0);
    ASSERT_TRUE(way);
    EXPECT_NEAR((*way - Vector2d::UnitX()).norm(), 0.0, 0.02);
    EXPECT_FALSE(way_off(bare, measured, {25.0, 0.0}, 2.0));
    EXPECT_FALSE(way_off(bare, {}, {20.0, 0.0}, 2.0));
}

}  // namespace
}  // namespace cmm::acquisition
