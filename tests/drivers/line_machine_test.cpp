// SPDX-License-Identifier: Apache-2.0
// The line protocol: the same machine code, tags instead of transactions, a stop beside what is under way.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>

#include "machine_fixtures.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::drivers {
namespace {

using cmm::test::SerialWire;
using test::MachineRig;
using test::RecordingSink;
using test::scan_ring;

std::string line_url(const std::string& port) {
    return "line+serial://" + port + "?baud=115200";
}

sim::Listen line_on(const std::string& port) {
    sim::Listen listen;
    listen.kind = sim::Listen::Kind::line_serial;
    listen.line.path = port;
    return listen;
}

TEST(LineMachine, ScansTheSameCountsAsOverTcp) {
    const test::Workshop workshop;
    const auto over_tcp = [&] {
        const auto simulator = workshop.start(0.0);
        return scan_ring(simulator->url(), 3000);
    }();
    const SerialWire wire;
    const auto simulator = workshop.start(0.0, line_on(wire.device()));
    ASSERT_NE(simulator, nullptr);
    LinkStats stats;
    const auto over_line = scan_ring(line_url(wire.host()), 3000, &stats);
    EXPECT_EQ(stats.errors(), 0U);
    ASSERT_EQ(over_line.size(), over_tcp.size());
    for (std::size_t k = 0; k < over_line.size(); ++k)
        EXPECT_EQ(over_line[k].counts, over_tcp[k].counts) << k;
}

TEST(LineMachine, ANoisyLineCostsTimeAndNoSample) {
    SerialWire::Options options;
    options.seed = 11;
    SerialWire wire(options);
    const test::Workshop workshop;
    const auto simulator = workshop.start(0.0, line_on(wire.device()));
    ASSERT_NE(simulator, nullptr);
    wire.set_faults(1e-4, 1e-4);
    LinkStats stats;
    EXPECT_EQ(scan_ring(line_url(wire.host()), 2000, &stats).size(), 2000U);
    EXPECT_GT(wire.spoilt(), 0U);
    EXPECT_GT(stats.retries, 0U);
}

// The wire outlives what is plugged into it.
struct WithWire {
    SerialWire wire_;
};

class LineMachineTest : protected WithWire, public test::SimulatedMachineTest {
  protected:
    void bring_up(double speed) {
        ASSERT_NO_FATAL_FAILURE(start(speed, line_on(wire_.device())));
        ASSERT_NO_FATAL_FAILURE(SimulatedMachineTest::bring_up(test::settings_for(line_url(wire_.host()))));
        EXPECT_EQ(found_.model, "cmmlive sim");
        EXPECT_EQ(found_.serial, "SIM-0001");
        EXPECT_NEAR(found_.limit_min_mm.x(), -500.0, 1e-9);
    }
};

TEST_F(LineMachineTest, TouchGivesTheContactAndItsSample) {
    bring_up(0.0);
    RecordingSink sink;
    const auto contact = rig_->run(machine().touch({10.0, 0.0, 20.0}, 20.0, 2.0, sink));
    ASSERT_TRUE(contact) << contact.error().text();
    EXPECT_NEAR(contact->x(), test::centre_radius_mm, 0.005);
    ASSERT_EQ(sink.kept.size(), 1U);
    EXPECT_NE(sink.kept[0].flags & core::sample_flag::touch, 0);
}

TEST_F(LineMachineTest, AStopDuringAScanBrakesAndKeepsTheSamples) {
    bring_up(10.0);
    stop_during_a_scan();
    std::printf("stop on the wire %.3f ms after the request\n", machine().link_stats().last_stop_us * 1e-3);
}

TEST_F(LineMachineTest, AHostWhoseCableIsPulledLeavesAMachineThatStops) {
    bring_up(10.0);
    const auto points = test::circle_path(test::centre_radius_mm, 20.0, 4000, 2.0);
    PointList source(points);
    RecordingSink sink;
    const auto scanning = rig_->start(machine().scan(ScanPath{}, source, sink));
    ASSERT_TRUE(rig_->wait([&] { return sink.delivered() >= 20; }));
    wire_.unplug_host();
    ASSERT_TRUE(rig_->wait([&] { return scanning->done(); }));
    ASSERT_FALSE(*scanning->result);
    EXPECT_EQ(core::exit_code(scanning->result->error().code), 5) << scanning->result->error().text();
    EXPECT_NE(scanning->result->error().motion, core::Motion::stopped) << "nobody has seen it stop";
    wire_.plug_host();
    const auto state = rig_->run(machine().state());
    ASSERT_TRUE(state) << state.error().text();
    EXPECT_EQ(state->state, MachineState::stopped);
    EXPECT_FALSE(state->in_motion);
    EXPECT_NE(state->fault.find("watchdog"), std::string::npos) << state->fault;
    EXPECT_GE(state->newest_sequence, sink.last);
}

TEST_F(LineMachineTest, ARestartedControllerIsNoticed) {
    bring_up(0.0);
    simulator_.reset();
    start(0.0, line_on(wire_.device()));
    const auto state = rig_->run(machine().state());
    ASSERT_FALSE(state);
    EXPECT_EQ(state.error().code, core::ErrorCode::machine_fault);
    EXPECT_NE(state.error().text().find("boot id"), std::string::npos) << state.error().text();
}

TEST_F(LineMachineTest, AStopGetsThroughToAControllerThatAnswersNothing) {
    bring_up(10.0);
    simulator_.reset();  // from here a test listens
    const int device = ::open(wire_.device().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(device, 0);
    const auto asking = rig_->start(machine().state());
    std::string heard;
    const auto hears = [&](const std::string& word) {
        return rig_->wait([&] {
            std::array<char, 512> buffer;
            const auto got = ::read(device, buffer.data(), buffer.size());
            if (got > 0) heard.append(buffer.data(), static_cast<std::size_t>(got));
            return heard.find(word) != std::string::npos;
        });
    };
    ASSERT_TRUE(hears(" ST*"));
    machine().stop(StopKind::controlled);
    EXPECT_TRUE(hears(" STOP 1*"));
    machine().stop(StopKind::emergency);
    EXPECT_TRUE(hears(" STOP 2*"));
    EXPECT_TRUE(rig_->wait([&] { return asking->done(); }));
    EXPECT_FALSE(*asking->result);
    ::close(device);
}

TEST(LinePort, WhatIsNotThereIsSaidSo) {
    MachineRig missing(test::settings_for("line+serial:///dev/no-such-port"));
    const auto no_port = missing.run(missing.machine->connect());
    ASSERT_FALSE(no_port);
    EXPECT_EQ(no_port.error().code, core::ErrorCode::transport_connect);
    EXPECT_NE(no_port.error().text().find("/dev/no-such-port"), std::string::npos);
    const SerialWire wire;
    auto settings = test::settings_for(line_url(wire.host()));
    settings.response_timeout_ms = 30.0;
    MachineRig silent(settings);
    const auto nobody = silent.run(silent.machine->connect());
    ASSERT_FALSE(nobody);
    EXPECT_EQ(nobody.error().code, core::ErrorCode::transport_timeout);
    EXPECT_NE(nobody.error().text().find("baud and parity"), std::string::npos) << nobody.error().text();
}

}  // namespace
}  // namespace cmm::drivers
