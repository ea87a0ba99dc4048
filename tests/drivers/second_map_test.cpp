// SPDX-License-Identifier: Apache-2.0
// A controller that is laid out differently: driver and simulator know it from the same file and from nothing else.
#include <gtest/gtest.h>

#include "machine_fixtures.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::drivers {
namespace {

using test::MachineRig;
using test::RecordingSink;

constexpr const char* map_file = "config/maps/plc-le.toml";

class SecondMap : public test::SimulatedMachineTest {
  protected:
    void bring_up(double speed, const sim::Listen& listen = {}, const std::string& url = {}) {
        ASSERT_NO_FATAL_FAILURE(start(speed, listen, map_file));
        LinkSettings settings = test::settings_for(url.empty() ? simulator_->url() : url);
        settings.map_file = map_file;
        ASSERT_NO_FATAL_FAILURE(SimulatedMachineTest::bring_up(settings));
        EXPECT_DOUBLE_EQ(found_.lsb_mm, 200e-6);
        EXPECT_EQ(found_.path_window, 9U);
        EXPECT_NEAR(found_.limit_max_mm.z(), 700.0, 1e-9);
        EXPECT_EQ(found_.model, "cmmlive sim");
    }
    void scan(std::size_t count, double speed_mm_s, RecordingSink& sink) {
        const auto scanned =
            scan_points(test::circle_path(test::centre_radius_mm, 20.0, count, speed_mm_s), sink, {.id = 5});
        ASSERT_TRUE(scanned) << scanned.error().text();
        EXPECT_EQ(scanned->points_passed, count);
        EXPECT_EQ(sink.delivered(), count);
        EXPECT_TRUE(sink.out_of_order.empty());
        expect_on_circle(sink);
    }
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
    sink.on_delivery = [&] {
        if (sink.delivered() >= 20) machine().stop(StopKind::emergency);
    };
    const auto scanned = scan_points(test::circle_path(test::centre_radius_mm, 20.0, 2000, 2.0), sink);
    ASSERT_FALSE(scanned);
    EXPECT_EQ(scanned.error().code, core::ErrorCode::machine_emergency) << scanned.error().text();
    const auto state = rig_->run(machine().state());
    ASSERT_TRUE(state);
    EXPECT_EQ(state->state, MachineState::emergency);
    EXPECT_TRUE(state->homed && state->qualified && state->owned_by_us);
    EXPECT_FALSE(state->in_motion);
    EXPECT_EQ(state->fault, "emergency stop");
    test::expect_done(rig_->run(machine().clear_fault(true)));
}

TEST_F(SecondMap, TheOtherMapIsNotMistakenForIt) {
    start(0.0);
    LinkSettings settings = test::settings_for(simulator_->url());
    settings.map_file = map_file;
    MachineRig rig(settings);
    const auto found = rig.run(rig.machine->connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::protocol_mismatch) << found.error().text();
}

}  // namespace
}  // namespace cmm::drivers
