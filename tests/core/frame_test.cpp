// SPDX-License-Identifier: Apache-2.0
#include "core/frame.hpp"

#include <gtest/gtest.h>

#include "core/sample.hpp"
#include "core/units.hpp"

namespace cmm::core {
namespace {

TEST(Frame, ATransformAndItsInverseCancel) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.translate(Eigen::Vector3d(10, -4, 2.5));
    motion.rotate(Eigen::AngleAxisd(rad_from_deg(30), Eigen::Vector3d::UnitZ()));
    const PartFromMachine part_from_machine(motion);
    const Position<MachineFrame> p{{1, 2, 3}};
    const Position<PartFrame> q = part_from_machine(p);
    EXPECT_NEAR((part_from_machine.inverse()(q).mm - p.mm).norm(), 0.0, 1e-14);
    // 30 degrees about z takes (1, 2) to (cos 30 - 2 sin 30, sin 30 + 2 cos 30).
    EXPECT_NEAR(q.mm.x(), 10 + 0.8660254037844387 - 1.0, 1e-12);
    EXPECT_NEAR(q.mm.y(), -4 + 0.5 + 2 * 0.8660254037844387, 1e-12);
    EXPECT_NEAR(part_from_machine.rotate(Eigen::Vector3d::UnitX()).norm(), 1.0, 1e-15);
}

TEST(Units, CountsAreTheNearest) {
    EXPECT_EQ(counts_from_mm(1.00004, 1e-4), 10000);
    EXPECT_EQ(counts_from_mm(-1.00006, 1e-4), -10001);
    Sample sample;
    sample.counts = {10000, -5, 7};
    EXPECT_DOUBLE_EQ(centre_mm(sample, 1e-4).x(), 1.0);
    EXPECT_DOUBLE_EQ(um_from_mm(mm_from_um(3.5)), 3.5);
    EXPECT_DOUBLE_EQ(deg_from_rad(rad_from_deg(77.0)), 77.0);
    EXPECT_DOUBLE_EQ(mm_from_cm(2.54), 25.4);
}

}  // namespace
}  // namespace cmm::core
