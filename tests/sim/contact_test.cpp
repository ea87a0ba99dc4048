// SPDX-License-Identifier: Apache-2.0
#include "sim/contact.hpp"

#include <gtest/gtest.h>

#include "core/rng.hpp"
#include "sim/mesh.hpp"
#include "tests/sim/test_blades.hpp"
#include "tests/sim/test_meshes.hpp"

namespace cmm::sim {
namespace {

/// A sphere as its formula; counts how often it is asked.
class Sphere final : public Surface {
  public:
    explicit Sphere(double radius) : radius_(radius) {}
    Contact nearest(const Eigen::Vector3d& p, std::size_t& warm) const override {
        ++warm;
        const Eigen::Vector3d n = p.norm() > 0.0 ? Eigen::Vector3d(p.normalized()) : Eigen::Vector3d::UnitX();
        return {p.norm() - radius_, radius_ * n, n};
    }
    Box box() const override { return {Eigen::Vector3d::Constant(-radius_), Eigen::Vector3d::Constant(radius_)}; }

  private:
    double radius_;
};

TEST(TouchAlong, BallTouchesASphereWhereTheFormulaSays) {
    const Sphere sphere(10.0);
    core::Rng rng(1);
    for (int i = 0; i < 2000; ++i) {
        const Eigen::Vector3d to_pole(0.0, 0.0, 1.0);
        const Eigen::Vector3d start(rng.uniform(-7.0, 7.0), rng.uniform(-7.0, 7.0), rng.uniform(13.0, 16.0));
        std::size_t asked = 0;
        const auto ball = touch_along(sphere, start, -to_pole, -5.0, 20.0, 1.5, asked);
        ASSERT_TRUE(ball);
        const double z = std::sqrt(11.5 * 11.5 - start.head<2>().squaredNorm());
        EXPECT_NEAR(ball->s_mm, start.z() - z, 1e-7);
        EXPECT_NEAR(ball->centre.norm(), 11.5, 1e-7);
        EXPECT_NEAR((ball->centre - ball->foot).norm(), 1.5, 1e-7);
        EXPECT_NEAR(ball->normal.dot(ball->centre - ball->foot), 1.5, 1e-7);
        EXPECT_LE(asked, 40U);
    }
}

TEST(TouchAlong, FromInsideItComesBackOutOnTheSideItCameFrom) {
    const Sphere sphere(10.0);
    std::size_t warm = 0;
    for (const double z : {11.4, 5.0, 0.5, -5.0, -11.4}) {
        const auto ball = touch_along(sphere, {1.0, 0.0, z}, -Eigen::Vector3d::UnitZ(), -50.0, 50.0, 1.5, warm);
        ASSERT_TRUE(ball);
        EXPECT_NEAR(ball->centre.z(), std::sqrt(11.5 * 11.5 - 1.0), 1e-7);
    }
}

TEST(TouchAlong, LooksBehindWhenNothingIsAhead) {
    const Sphere sphere(10.0);
    std::size_t warm = 0;
    const auto ball = touch_along(sphere, {0.0, 0.0, -15.0}, -Eigen::Vector3d::UnitZ(), -50.0, 50.0, 1.0, warm);
    ASSERT_TRUE(ball);
    EXPECT_NEAR(ball->centre.z(), 11.0, 1e-7);
}

TEST(TouchAlong, KeepsToItsLimits) {
    const Sphere sphere(10.0);
    std::size_t warm = 0;
    EXPECT_FALSE(touch_along(sphere, {0.0, 0.0, 15.0}, -Eigen::Vector3d::UnitZ(), -1.0, 3.9, 1.0, warm));
    EXPECT_TRUE(touch_along(sphere, {0.0, 0.0, 15.0}, -Eigen::Vector3d::UnitZ(), -1.0, 4.1, 1.0, warm));
    EXPECT_FALSE(touch_along(sphere, {0.0, 0.0, 10.0}, -Eigen::Vector3d::UnitZ(), -0.9, 4.1, 1.0, warm));
    EXPECT_TRUE(touch_along(sphere, {0.0, 0.0, 10.0}, -Eigen::Vector3d::UnitZ(), -1.1, 4.1, 1.0, warm));
}

TEST(TouchAlong, Grazing) {
    const Sphere sphere(10.0);
    const auto at = [&](double miss) {
        std::size_t asked = 0;
        const auto ball =
            touch_along(sphere, {11.0 + miss, 0.0, 15.0}, -Eigen::Vector3d::UnitZ(), 0.0, 30.0, 1.0, asked);
        EXPECT_LT(asked, 1500U);
        return ball;
    };
    for (const double dip : {1e-2, 1e-4, 1e-6}) {
        const auto ball = at(-dip);
        ASSERT_TRUE(ball) << dip;
        EXPECT_NEAR(ball->centre.norm(), 11.0, 2e-7);
        EXPECT_GT(ball->centre.z(), -1e-2);  // the first of the two roots
    }
    EXPECT_FALSE(at(1e-5));
    EXPECT_FALSE(at(1e-3));
}

TEST(TouchAlong, LeaningWallMovesTheBallOutByTheSecantOfTheLean) {
    // A cone whose wall leans by alpha to the axis: the centre in a plane z stands off by r / cos(alpha) from the
    // wall's circle in the same plane.
    const double alpha = core::rad_from_deg(20.0), r = 1.5, base = 20.0;
    const MeshSurface cone(test::revolve({{base, 0.0}, {base - 30.0 * std::tan(alpha), 30.0}}, 3600));
    std::size_t warm = 0;
    for (const double a : {0.0, 1.0, 2.5, 4.0}) {
        const Eigen::Vector3d out(std::cos(a), std::sin(a), 0.0);
        const auto ball = touch_along(cone, 25.0 * out + Eigen::Vector3d(0.0, 0.0, 12.0), -out, 0.0, 30.0, r, warm);
        ASSERT_TRUE(ball);
        const double wall = base - 12.0 * std::tan(alpha);
        EXPECT_NEAR(ball->centre.head<2>().norm(), wall + r / std::cos(alpha), 1e-5);
        EXPECT_NEAR(ball->foot.z(), 12.0 - r * std::sin(alpha), 1e-5);
    }
}

TEST(TouchAlong, FollowsABladeAllTheWayRound) {
    const auto patch = BladePatch::make(test::twisted_blade(), 2.0).value();
    const PatchSurface surface(patch);
    const double period = patch->u_breaks().back(), r = 1.0;
    std::size_t warm = 0;
    for (int i = 0; i < 2000; ++i) {
        const PatchPoint p = patch->at(period * i / 2000.0, 25.0 + 0.01 * i);
        const Eigen::Vector3d n = p.su.cross(p.sv).normalized();
        const Eigen::Vector3d flat = Eigen::Vector3d(n.x(), n.y(), 0.0).normalized();
        const Eigen::Vector3d start = p.s + r * flat + (i % 2 ? 0.3 : -0.3) * flat;
        const auto ball = touch_along(surface, start, -flat, -3.0, 3.0, r, warm);
        ASSERT_TRUE(ball);
        EXPECT_NEAR(ball->centre.z(), p.s.z(), 1e-12);
        EXPECT_NEAR(surface.nearest(ball->centre, warm).distance_mm, r, 2e-8);
        EXPECT_LT(std::abs(ball->s_mm), 0.5);
    }
}

}  // namespace
}  // namespace cmm::sim
