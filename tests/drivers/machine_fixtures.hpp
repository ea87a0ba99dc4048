// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "machine_rig.hpp"
#include "workshop.hpp"

namespace cmm::drivers::test {

inline void expect_done(const core::Status& status) {
    EXPECT_TRUE(status) << status.error().text();
}

/// Homes, qualifies and moves to where the ring of the prism is approached from.
inline void bring_beside_part(MachineRig& rig) {
    Machine& machine = *rig.machine;
    expect_done(rig.run(machine.home()));
    expect_done(rig.run(machine.qualify(ball_radius_mm)));
    expect_done(rig.run(machine.move({40.0, 0.0, 60.0}, 200.0)));
    expect_done(rig.run(machine.move({40.0, 0.0, 20.0}, 200.0)));
}

/// Homes, qualifies and scans a ring of a simulated part; the samples as the driver gave them.
inline std::vector<core::Sample> scan_ring(const std::string& url, std::size_t count, LinkStats* stats = nullptr) {
    MachineRig rig(settings_for(url));
    Machine& machine = *rig.machine;
    RecordingSink sink;
    const auto found = rig.run(machine.connect());
    EXPECT_TRUE(found) << found.error().text();
    if (!found) return {};
    EXPECT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    bring_beside_part(rig);
    const auto points = circle_path(centre_radius_mm, 20.0, count, 50.0);
    PointList source(points);
    const auto scanned = rig.run(machine.scan(ScanPath{.id = 3}, source, sink));
    EXPECT_TRUE(scanned) << scanned.error().text();
    expect_done(rig.run(machine.end_run()));
    EXPECT_TRUE(sink.out_of_order.empty());
    EXPECT_EQ(sink.kept.size(), count);
    if (stats != nullptr) *stats = machine.link_stats();
    return sink.kept;
}

/// One machine under test, behind whatever link.
class MachineTest : public testing::Test {
  protected:
    Machine& machine() { return *rig_->machine; }
    void link_to(const LinkSettings& settings) { rig_ = std::make_unique<MachineRig>(settings); }
    void begin() {
        const auto found = rig_->run(machine().connect());
        ASSERT_TRUE(found) << found.error().text();
        found_ = *found;
        const auto origin = rig_->run(machine().begin_run(std::nullopt));
        ASSERT_TRUE(origin) << origin.error().text();
    }
    core::Result<ScanResult> scan_points(const std::vector<PathPoint>& points, RecordingSink& sink,
                                         const ScanPath& path = {}) {
        PointList source(points);
        return rig_->run(machine().scan(path, source, sink));
    }

    std::unique_ptr<MachineRig> rig_;
    Capabilities found_;
};

/// A machine whose controller is a simulator, with the ball beside the prism.
class SimulatedMachineTest : public MachineTest {
  protected:
    void start(double speed, const sim::Listen& listen = {}, const std::string& map = "config/maps/cmm-v1.toml") {
        simulator_ = workshop_.start(speed, listen, map);
        ASSERT_NE(simulator_, nullptr);
    }
    void bring_up(const LinkSettings& settings) {
        link_to(settings);
        ASSERT_NO_FATAL_FAILURE(begin());
        bring_beside_part(*rig_);
    }
    void expect_on_circle(const RecordingSink& sink) const {
        for (const auto& sample : sink.kept) {
            const Eigen::Vector3d centre = core::centre_mm(sample, found_.lsb_mm);
            ASSERT_NEAR(centre.head<2>().norm(), centre_radius_mm, 0.002) << "sample " << sample.sequence;
        }
    }
    void stop_during_a_scan() {
        RecordingSink sink;
        sink.on_delivery = [&] {
            if (sink.delivered() >= 20) machine().stop(StopKind::controlled);
        };
        const auto scanned = scan_points(circle_path(centre_radius_mm, 20.0, 2000, 2.0), sink);
        ASSERT_FALSE(scanned);
        EXPECT_EQ(scanned.error().code, core::ErrorCode::cancelled) << scanned.error().text();
        EXPECT_EQ(scanned.error().motion, core::Motion::stopped);
        const auto state = rig_->run(machine().state());
        ASSERT_TRUE(state);
        EXPECT_EQ(state->state, MachineState::stopped);
        EXPECT_EQ(state->newest_sequence, sink.last);
        EXPECT_EQ(state->acknowledged_sequence, sink.last);
    }

    Workshop workshop_;
    std::unique_ptr<sim::Simulator> simulator_;
};

/// A machine whose controller is played by the test: each reply and each silence is decided there.
class PlayedMachineTest : public MachineTest {
  protected:
    explicit PlayedMachineTest(const std::string& url) : settings_(settings_for(url)) {
        settings_.response_timeout_ms = 40.0;  // the tests wait for it often
        link_to(settings_);
    }
    core::Result<ScanResult> scan(std::size_t points, RecordingSink& sink) {
        return scan_points(circle_path(20.0, 5.0, points, 10.0), sink);
    }

    LinkSettings settings_;
};

}  // namespace cmm::drivers::test
