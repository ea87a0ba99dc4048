// SPDX-License-Identifier: Apache-2.0
// A controller that is laid out differently: driver and simulator know it from the same file and from nothing else.
#include <gtest/gtest.h>

#include "machine_rig.hpp"
#include "tests/support/serial_wire.hpp"
#include "workshop.hpp"

namespace cmm::drivers {
namespace {

using test::MachineRig;
using test::RecordingSink;

constexpr const char* map_file = "config/maps/plc-le.toml";

class SecondMap : public testing::Test {
  protected:
    void bring_up(double speed, const sim::Listen& listen = {}, const std::string& url = {}) {
        simulator_ = workshop_.start(speed, listen, map_file);
        ASSERT_NE(simulator_, nullptr);
        LinkSettings settings = test::settings_for(url.empty() ? simulator_->url() : url);
        settings.map_file = map_file;
        rig_ = std::make_unique<MachineRig>(settings);
        const auto found = rig_->run(machine().connect());
        ASSERT_TRUE(found) << found.error().text();
        lsb_mm_ = found->lsb_mm;
        EXPECT_DOUBLE_EQ(lsb_mm_, 200e-6);
        EXPECT_EQ(found->path_window, 9U);
        EXPECT_NEAR(found->limit_max_mm.z(), 700.0, 1e-9);
        EXPECT_EQ(found->model, "cmmlive sim");
        ASSERT_TRUE(rig_->run(machine().begin_run(std::nullopt)));
        expect_done(rig_->run(machine().home()));
        expect_done(rig_->run(machine().qualify(test::ball_radius_mm)));
        expect_done(rig_->run(machine().move({40.0, 0.0, 60.0}, 200.0)));
        expect_done(rig_->run(machine().move({40.0, 0.0, 20.0}, 200.0)));
    }
    static void expect_done(const core::Status& status) { EXPECT_TRUE(status) << status.error().text(); }
    Machine& machine() { return *rig_->machine; }
    void scan(std::size_t count, double speed_mm_s, RecordingSink& sink) {
        const auto points = test::circle_path(test::centre_radius_mm, 20.0, count, speed_mm_s);
        PointList source(points);
        const auto scanned = rig_->run(machine().scan(ScanPath{.id = 5}, source, sink));
        ASSERT_TRUE(scanned) << scanned.error().text();
        EXPECT_EQ(scanned->points_passed, count);
        EXPECT_EQ(sink.delivered(), count);
        EXPECT_TRUE(sink.out_of_order.empty());
        for (const auto& sample : sink.kept)
            ASSERT_NEAR(core::centre_mm(sample, lsb_mm_).head<2>().norm(), test::centre_radius_mm, 0.002);
    }

    test::Workshop workshop_;
    std::unique_ptr<sim::Simulator> simulator_;
    std::unique_ptr<MachineRig> rig_;
    double lsb_mm_ = 0.0;
};

TEST_F(SecondMap, APathLongerThanItsCountersIsScanned) {
    bring_up(0.0);
    RecordingSink sink;
    scan(70'000, 300.0, sink);
    EXPECT_EQ(machine().link_stats().errors(), 0U);
}

TEST_F(SecondMap, TheSameOnASerialLine) {
    const cmm::test::SerialWire wire;
    sim::Listen listen;
    listen.kind = sim::Listen::Kind::modbus_rtu;
    listen.line.path = wire.device();
    bring_up(0.0, listen, "modbus+rtu://" + wire.host() + "?parity=none");
    RecordingSink sink;
    scan(500, 50.0, sink);
    std::int64_t before_us = 0;
    for (const auto& sample : sink.kept) {
        EXPECT_GE(sample.machine_time_us - before_us, 950) << "not faster than the sample clock, to one step of 25 us";
        before_us = sample.machine_time_us;
    }
}

TEST_F(SecondMap, TouchStopAndFaultAreUnderstood) {
    bring_up(10.0);
    RecordingSink sink;
    const auto contact = rig_->run(machine().touch({10.0, 0.0, 20.0}, 20.0, 2.0, sink));
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_NEAR(contact->x(), test::centre_radius_mm, 0.005);
    ASSERT_EQ(sink.kept.size(), 1U);
    EXPECT_NE(sink.kept[0].flags & core::sample_flag::touch, 0);
    const auto points = test::circle_path(test::centre_radius_mm, 20.0, 2000, 2.0);
    PointList source(points);
    sink.on_delivery = [&] {
        if (sink.delivered() >= 20) machine().stop(StopKind::emergency);
    };
    const auto scanned = rig_->run(machine().scan(ScanPath{}, source, sink));
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, core::ErrorCode::machine_emergency) << scanned.error().text();
    const auto state = rig_->run(machine().state());
    ASSERT_TRUE(state);
    EXPECT_EQ(state->state, MachineState::emergency);
    EXPECT_TRUE(state->homed && state->qualified && state->owned_by_us);
    EXPECT_FALSE(state->in_motion);
    EXPECT_EQ(state->fault, "emergency stop");
    expect_done(rig_->run(machine().clear_fault(true)));
}

TEST_F(SecondMap, TheOtherMapIsNotMistakenForIt) {
    simulator_ = workshop_.start(0.0);
    LinkSettings settings = test::settings_for(simulator_->url());
    settings.map_file = map_file;
    MachineRig rig(settings);
    const auto found = rig.run(rig.machine->connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::protocol_mismatch) << found.error().text();
}

}  // namespace
}  // namespace cmm::drivers
