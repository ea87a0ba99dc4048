// SPDX-License-Identifier: Apache-2.0
#include "sim/travel.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/controller_rig.hpp"

namespace cmm::sim::test {
namespace {

const Bar bar(bar_radius_mm);

TEST(Travel, HeadOnAndObliqueContactAreWhereGeometrySays) {
    const auto head_on = first_contact(bar, {50, 0, 0}, {0, 0, 0}, ball_radius_mm);
    ASSERT_TRUE(head_on);
    EXPECT_NEAR(*head_on, 50.0 - circle_mm, 2e-6);
    const double offset = 10.9;  // a line that cuts 0.1 mm deep into the ball's circle
    const auto oblique = first_contact(bar, {50, offset, 5}, {-50, offset, 5}, ball_radius_mm);
    ASSERT_TRUE(oblique);
    EXPECT_NEAR(*oblique, 50.0 - std::sqrt(circle_mm * circle_mm - offset * offset), 1e-4);
}

TEST(Travel, PassingByAndStoppingShortAreFree) {
    EXPECT_FALSE(first_contact(bar, {50, 11.001, 0}, {-50, 11.001, 0}, ball_radius_mm));
    EXPECT_FALSE(first_contact(bar, {50, 0, 0}, {11.001, 0, 0}, ball_radius_mm));
    EXPECT_FALSE(first_contact(bar, {50, 0, 0}, {50, 0, 0}, ball_radius_mm));
}

TEST(Travel, ABallInContactMayLeaveButNotGoDeeper) {
    EXPECT_FALSE(first_contact(bar, {11, 0, 0}, {20, 0, 0}, ball_radius_mm));
    EXPECT_FALSE(first_contact(bar, {11, 0, 0}, {11, 0, 30}, ball_radius_mm)) << "sliding along the bar";
    const auto deeper = first_contact(bar, {11, 0, 0}, {0, 0, 0}, ball_radius_mm);
    ASSERT_TRUE(deeper);
    EXPECT_NEAR(*deeper, 0.0, 0.011);
}

TEST(Travel, ABallThatLeftMayTouchAgain) {
    const Eigen::Vector3d from(11, 0, 0);
    const Eigen::Vector3d to(11.5, 0, 0);
    EXPECT_FALSE(first_contact(bar, from, to, ball_radius_mm));
    // A pit in the wall: out of one side, into the other.
    class Slot final : public Surface {
      public:
        Contact nearest(const Eigen::Vector3d& p, std::size_t&) const override {
            const double left = p.x() + 5.0;
            const double right = 5.0 - p.x();
            return left < right ? Contact{left, {-5, p.y(), p.z()}, {1, 0, 0}}
                                : Contact{right, {5, p.y(), p.z()}, {-1, 0, 0}};
        }
        Box box() const override { return {{-6, -1, -1}, {6, 1, 1}}; }
    };
    const auto across = first_contact(Slot(), {-4, 0, 0}, {6, 0, 0}, 1.0);
    ASSERT_TRUE(across);
    EXPECT_NEAR(*across, 8.0, 2e-6);
}

}  // namespace
}  // namespace cmm::sim::test
