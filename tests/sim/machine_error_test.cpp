// SPDX-License-Identifier: Apache-2.0
#include "sim/machine_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "sim/grown.hpp"
#include "sim/patch.hpp"
#include "test_blades.hpp"

namespace cmm::sim {
namespace {

using Eigen::Vector3d;

TEST(MachineError, AxesReadTooLongAndAreNotSquare) {
    MachineError error;
    error.scale = {1e-5, -2e-5, 3e-5};
    error.squareness = {4e-5, 0.0, 5e-5};
    const Vector3d off = error.at({100.0, 50.0, 20.0}, Vector3d::UnitX());
    EXPECT_NEAR(off.x(), 1e-5 * 100.0 + 4e-5 * 50.0, 1e-12);
    EXPECT_NEAR(off.y(), -2e-5 * 50.0 + 5e-5 * 20.0, 1e-12);
    EXPECT_NEAR(off.z(), 3e-5 * 20.0, 1e-12);
    EXPECT_EQ(MachineError().at({100.0, 50.0, 20.0}, Vector3d::UnitX()), Vector3d::Zero());
}

TEST(MachineError, LobesAreFeltAlongTheNormalByItsDirection) {
    MachineError error;
    error.lobes_mm = 0.002;
    error.lobes_from_rad = 0.3;
    for (int k = 0; k < 12; ++k) {
        const double direction = 0.3 + k * std::numbers::pi / 6.0;
        const Vector3d normal(std::cos(direction), std::sin(direction), 0.0);
        const Vector3d off = error.at({7.0, 8.0, 9.0}, normal);
        EXPECT_NEAR(off.dot(normal), 0.002 * std::cos(3.0 * k * std::numbers::pi / 6.0), 1e-12);
        EXPECT_NEAR(off.norm(), std::abs(off.dot(normal)), 1e-12);
    }
    EXPECT_EQ(error.at({7.0, 8.0, 9.0}, Vector3d::UnitZ()), Vector3d::Zero()) << "from above no direction is felt";
}

TEST(GrownSurface, IsTheSamePartLarger) {
    const auto patch = BladePatch::make(test::twisted_blade(), 0.0);
    ASSERT_TRUE(patch);
    const auto part = std::make_shared<PatchSurface>(*patch);
    const GrownSurface grown(part, 1.001);
    std::size_t warm = 0, warm_grown = 0;
    const Vector3d from(4.0, 12.0, 30.0);
    const Contact as_made = part->nearest(from, warm), larger = grown.nearest(1.001 * from, warm_grown);
    EXPECT_NEAR((larger.point - 1.001 * as_made.point).norm(), 0.0, 1e-9);
    EXPECT_NEAR(larger.distance_mm, 1.001 * as_made.distance_mm, 1e-9);
    EXPECT_NEAR((larger.normal - as_made.normal).norm(), 0.0, 1e-9);
    EXPECT_NEAR((grown.box().high - 1.001 * part->box().high).norm(), 0.0, 1e-9);
}

}  // namespace
}  // namespace cmm::sim
