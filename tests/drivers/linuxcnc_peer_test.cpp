// SPDX-License-Identifier: Apache-2.0
// The driver on LinuxCNC itself, whose probe trips on a ball that its HAL file computes.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <optional>

#include "core/units.hpp"
#include "machine_rig.hpp"
#include "tests/support/linuxcnc_peer.hpp"

namespace cmm::drivers {
namespace {

using cmm::test::LinuxcncPeer;
using core::ErrorCode;
using Eigen::Vector3d;
using test::MachineRig;
using test::RecordingSink;

const Vector3d ball_mm(100.0, 100.0, -100.0);  // tests/peers/linuxcnc/bodies.hal
constexpr double ball_radius_mm = 15.0;
constexpr double clearance_mm = 1.0;
constexpr double travel_mm_s = 100.0;

struct Sphere {
    Vector3d centre_mm;
    double radius_mm, form_mm;
};

/// Least squares of the algebraic distance: |p|^2 = 2 c.p + r^2 - c^2. Form is the span of the radial deviations.
Sphere fit_sphere(const std::vector<Vector3d>& points) {
    const auto rows = static_cast<Eigen::Index>(points.size());
    Eigen::MatrixX4d equations(rows, 4);
    Eigen::VectorXd squares(rows);
    for (Eigen::Index row = 0; row < rows; ++row) {
        const Vector3d point = points[static_cast<std::size_t>(row)] - ball_mm;
        equations.row(row) << 2.0 * point.transpose(), 1.0;
        squares[row] = point.squaredNorm();
    }
    const Eigen::Vector4d found = equations.colPivHouseholderQr().solve(squares);
    Sphere sphere{found.head<3>() + ball_mm, std::sqrt(found[3] + found.head<3>().squaredNorm()), 0.0};
    double low = 1e9;
    double high = -1e9;
    for (const auto& point : points) {
        const double off = (point - sphere.centre_mm).norm() - sphere.radius_mm;
        low = std::min(low, off);
        high = std::max(high, off);
    }
    sphere.form_mm = high - low;
    return sphere;
}

class OnLinuxcnc : public testing::Test {
  protected:
    void SetUp() override {
        if (const auto obstacle = LinuxcncPeer::obstacle(); !obstacle.empty()) GTEST_SKIP() << obstacle;
        linuxcnc_.emplace(folder_ / "linuxcnc");
        LinkSettings settings = test::settings_for(LinuxcncPeer::url);
        settings.linuxcnc.reset_estop = true;
        settings.linuxcnc.latch_delay_us = LinuxcncPeer::latch_delay_us;
        rig_ = std::make_unique<MachineRig>(settings);
        core::Result<Capabilities> found;
        const bool up = cmm::test::wait_for([&] {
            found = rig_->run(machine().connect());
            return found.has_value() || !linuxcnc_->running();
        });
        ASSERT_TRUE(up && found) << linuxcnc_->said();
        EXPECT_EQ(found->model, "LinuxCNC");
        EXPECT_TRUE(found->touches);
        ASSERT_TRUE(rig_->run(machine().begin_run(std::nullopt)));
        const auto homed = rig_->run(machine().home());
        ASSERT_TRUE(homed) << homed.error().text();
    }
    Machine& machine() { return *rig_->machine; }
    core::Status move(const Vector3d& target_mm) { return rig_->run(machine().move(target_mm, travel_mm_s)); }
    MachineStatus state() {
        auto now = rig_->run(machine().state());
        EXPECT_TRUE(now) << now.error().text();
        return now.value_or(MachineStatus{});
    }

    cmm::test::TemporaryFolder folder_;
    std::optional<LinuxcncPeer> linuxcnc_;
    std::unique_ptr<MachineRig> rig_;
};

Vector3d direction(int ring, int place) {
    const double elevation = core::rad_from_deg(55.0 - 25.0 * ring);
    const double azimuth = core::rad_from_deg(36.0 * place);
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
}

TEST_F(OnLinuxcnc, ProbesABall) {
    const double out_mm = ball_radius_mm + clearance_mm;
    ASSERT_TRUE(move({ball_mm.x() + out_mm * direction(0, 0).x(), ball_mm.y(), -50.0}));
    RecordingSink sink;
    std::vector<Vector3d> points;
    for (int ring = 0; ring < 4; ++ring) {
        for (int place = 0; place < 10; ++place) {
            // To and fro: between neighbours the way is free.
            const Vector3d normal = direction(ring, ring % 2 == 0 ? place : 9 - place);
            // Every touch meets the servo cycle at another instant.
            const double start_mm = out_mm + 0.00037 * static_cast<double>(points.size());
            const auto there = move(ball_mm + start_mm * normal);
            ASSERT_TRUE(there) << there.error().text();
            const auto contact =
                rig_->run(machine().touch(ball_mm + (ball_radius_mm - 0.5) * normal, 2.0, clearance_mm, sink));
            ASSERT_TRUE(contact) << contact.error().text();
            points.push_back(*contact);
        }
    }
    ASSERT_EQ(points.size(), 40U);
    ASSERT_EQ(sink.kept.size(), 40U);
    EXPECT_TRUE(sink.out_of_order.empty());
    for (std::size_t k = 0; k < points.size(); ++k) {
        EXPECT_LT((core::centre_mm(sink.kept[k], 1e-5) - points[k]).norm(), 2e-5);
        EXPECT_EQ(sink.kept[k].flags, core::sample_flag::touch);
    }
    const Sphere sphere = fit_sphere(points);
    RecordProperty("radius_mm", std::to_string(sphere.radius_mm));
    RecordProperty("form_mm", std::to_string(sphere.form_mm));
    std::printf("radius %.6f mm, form %.6f mm, centre off by %.6f mm\n", sphere.radius_mm, sphere.form_mm,
                (sphere.centre_mm - ball_mm).norm());
    EXPECT_NEAR(sphere.radius_mm, ball_radius_mm, 0.001);
    EXPECT_LT(sphere.form_mm, 0.003);
    EXPECT_LT((sphere.centre_mm - ball_mm).norm(), 0.002);
    EXPECT_TRUE(rig_->run(machine().end_run()));
}

TEST_F(OnLinuxcnc, SaysWhatDidNotWork) {
    RecordingSink sink;
    // Beyond the axis limit: LinuxCNC itself refuses, nothing moves, and the next motion works.
    const auto beyond = move({900.0, 0.0, 0.0});
    ASSERT_FALSE(beyond);
    EXPECT_EQ(beyond.error().code, ErrorCode::machine_limit) << beyond.error().text();
    EXPECT_EQ(beyond.error().motion, core::Motion::stopped);
    const auto too_far = rig_->run(machine().touch({-20.0, 0.0, 0.0}, 10.0, 1.0, sink));
    ASSERT_FALSE(too_far);
    EXPECT_EQ(too_far.error().code, ErrorCode::machine_limit) << too_far.error().text();
    ASSERT_TRUE(move({50.0, 50.0, 0.0}));

    // Nothing there, after a touch that found something: its flag must not count.
    ASSERT_TRUE(move({100.0, 100.0, -80.0}));
    const auto hit = rig_->run(machine().touch({100.0, 100.0, -86.0}, 10.0, 2.0, sink));
    ASSERT_TRUE(hit) << hit.error().text();
    EXPECT_NEAR(hit->z(), -85.0, 0.011);
    EXPECT_NEAR(state().position_mm.z(), hit->z() + 2.0, 1e-3);
    const Vector3d above(100.0, 100.0, -60.0);
    ASSERT_TRUE(move(above));
    const auto miss = rig_->run(machine().touch({100.0, 100.0, -64.0}, 20.0, 1.0, sink));
    ASSERT_FALSE(miss);
    EXPECT_EQ(miss.error().code, ErrorCode::machine_no_contact) << miss.error().text();
    EXPECT_LT((state().position_mm - above).norm(), 1e-3);
    EXPECT_EQ(sink.kept.size(), 1U);

    // Into the ball without a touch being asked for.
    const auto crash = move({100.0, 100.0, -95.0});
    ASSERT_FALSE(crash);
    EXPECT_EQ(crash.error().code, ErrorCode::machine_fault) << crash.error().text();
    EXPECT_EQ(crash.error().motion, core::Motion::stopped);
    EXPECT_FALSE(state().in_contact);
    EXPECT_EQ(state().state, MachineState::fault);
    EXPECT_FALSE(move(above));
    ASSERT_TRUE(rig_->run(machine().clear_fault()));
    ASSERT_TRUE(move(above));
}

TEST_F(OnLinuxcnc, StopsInMotion) {
    for (const StopKind kind : {StopKind::controlled, StopKind::emergency}) {
        const bool emergency = kind == StopKind::emergency;
        ASSERT_TRUE(move({0.0, 0.0, 0.0}));
        const auto moving = rig_->start(machine().move({400.0, 0.0, 0.0}, 20.0));
        ASSERT_TRUE(rig_->wait([&] { return state().position_mm.x() > 1.0; }));
        const auto asked = std::chrono::steady_clock::now();
        machine().stop(kind);
        machine().stop(kind);
        ASSERT_TRUE(rig_->wait([&] { return moving->done(); }));
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - asked;
        ASSERT_FALSE(*moving->result);
        const auto& error = moving->result->error();
        EXPECT_EQ(error.code, emergency ? ErrorCode::machine_emergency : ErrorCode::cancelled) << error.text();
        EXPECT_EQ(error.motion, core::Motion::stopped);
        const auto stopped = state();
        EXPECT_EQ(stopped.state, emergency ? MachineState::emergency : MachineState::stopped);
        std::printf("%s: known to stand after %.0f ms, %.1f mm gone\n", emergency ? "emergency stop" : "stop",
                    took.count(), stopped.position_mm.x());
        EXPECT_LT(stopped.position_mm.x(), 300.0);
        EXPECT_FALSE(move({0.0, 0.0, 0.0}));
        ASSERT_TRUE(rig_->run(machine().clear_fault(emergency)));
        EXPECT_EQ(state().state, MachineState::idle);
        EXPECT_TRUE(state().homed);
        EXPECT_EQ(state().position_mm.x(), stopped.position_mm.x());
    }
    ASSERT_TRUE(move({0.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace cmm::drivers
