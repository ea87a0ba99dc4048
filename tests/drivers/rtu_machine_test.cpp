// SPDX-License-Identifier: Apache-2.0
// Modbus RTU: the same machine code on a serial line, where replies carry no id and bytes get lost.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdio>

#include "machine_fixtures.hpp"
#include "scripted_serial.hpp"
#include "tests/support/serial_gateway.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::drivers {
namespace {

using cmm::test::SerialWire;
using test::Fault;
using test::MachineRig;
using test::RecordingSink;
using test::Request;
using test::scan_ring;
using test::ScriptedSerial;

std::string rtu_url(const std::string& port) {
    return "modbus+rtu://" + port + "?baud=115200&parity=none&unit=1";
}

sim::Listen rtu_on(const std::string& port) {
    sim::Listen listen;
    listen.kind = sim::Listen::Kind::modbus_rtu;
    listen.line.path = port;
    return listen;
}

TEST(RtuMachine, ScansTheSameCountsAsOverTcp) {
    const test::Workshop workshop;
    const auto over_tcp = [&] {
        const auto simulator = workshop.start(0.0);
        return scan_ring(simulator->url(), 1500);
    }();
    const SerialWire wire;
    const auto simulator = workshop.start(0.0, rtu_on(wire.device()));
    ASSERT_NE(simulator, nullptr);
    LinkStats stats;
    const auto over_rtu = scan_ring(rtu_url(wire.host()), 1500, &stats);
    EXPECT_EQ(stats.errors(), 0U);
    ASSERT_EQ(over_rtu.size(), over_tcp.size());
    for (std::size_t k = 0; k < over_rtu.size(); ++k) {
        EXPECT_EQ(over_rtu[k].counts, over_tcp[k].counts) << k;
        EXPECT_EQ(over_rtu[k].sequence, over_tcp[k].sequence);
    }
}

TEST(RtuMachine, AGatewayPassesTheFramesOn) {
    const SerialWire wire;
    const test::Workshop workshop;
    const auto simulator = workshop.start(0.0, rtu_on(wire.device()));
    ASSERT_NE(simulator, nullptr);
    const cmm::test::SerialGateway gateway(wire.host());
    EXPECT_EQ(scan_ring("modbus+rtu+tcp://127.0.0.1:" + std::to_string(gateway.port()), 300).size(), 300U);
}

TEST(RtuMachine, ANoisyLineCostsTimeAndNoSample) {
    SerialWire::Options options;
    options.seed = 7;
    SerialWire wire(options);
    const test::Workshop workshop;
    const auto simulator = workshop.start(0.0, rtu_on(wire.device()));
    ASSERT_NE(simulator, nullptr);
    wire.set_faults(1e-4, 1e-4);
    LinkStats stats;
    EXPECT_EQ(scan_ring(rtu_url(wire.host()), 2000, &stats).size(), 2000U);
    EXPECT_GT(wire.spoilt(), 0U);
    EXPECT_GT(stats.retries, 0U);
    EXPECT_GT(stats.errors(), 0U);
}

/// A controller whose every reply and silence the test decides.
struct WithController {
    SerialWire wire_;
    ScriptedSerial controller_{wire_.device()};
};

class RtuFault : protected WithController, public test::PlayedMachineTest {
  protected:
    RtuFault() : PlayedMachineTest(rtu_url(wire_.host())) {}
};

class RtuScanFault : public RtuFault, public testing::WithParamInterface<Fault> {};

TEST_P(RtuScanFault, NoSampleIsLostOrDoubled) {
    begin();
    controller_.on_request([](const Request& request) {
        return request.number % 7 == 0 && request.function != 6 ? GetParam() : Fault::none;
    });
    RecordingSink sink;
    const auto scanned = scan(200, sink);
    ASSERT_TRUE(scanned) << scanned.error().text();
    EXPECT_EQ(sink.delivered(), 200U);
    EXPECT_TRUE(sink.out_of_order.empty());
    for (const int opcode : {7, 10})
        EXPECT_EQ(controller_.executed(opcode), 1);
    const auto path = test::circle_path(20.0, 5.0, 200, 10.0);
    for (std::size_t k = 0; k < path.size(); ++k)
        EXPECT_LT((core::centre_mm(sink.kept[k], 1e-4) - path[k].centre_mm).norm(), 1e-4) << k;
    EXPECT_GT(machine().link_stats().retries, 0U);
    EXPECT_EQ(controller_.crc_errors(), 0);
}

std::string fault_name(const testing::TestParamInfo<Fault>& info) {
    switch (info.param) {
        case Fault::silent:
            return "Silent";
        case Fault::lost_reply:
            return "LostReply";
        case Fault::late_reply:
            return "LateReply";
        case Fault::truncated:
            return "Truncated";
        case Fault::bad_crc:
            return "BadCrc";
        default:
            return "Garbage";
    }
}

INSTANTIATE_TEST_SUITE_P(Faults, RtuScanFault,
                         testing::Values(Fault::silent, Fault::lost_reply, Fault::late_reply, Fault::truncated,
                                         Fault::bad_crc, Fault::garbage),
                         fault_name);

TEST_F(RtuFault, ALateReplyIsNotTakenForTheNextRequest) {
    begin();
    std::atomic<bool> spoilt{false};
    // The status before the command is asked for once more, and answered twice: the first answer comes too late.
    controller_.on_request([&](const Request& request) {
        return request.function == 3 && request.address == 64 && !spoilt.exchange(true) ? Fault::late_reply
                                                                                        : Fault::none;
    });
    const auto homed = rig_->run(machine().home());
    EXPECT_TRUE(homed) << homed.error().text();
    EXPECT_TRUE(spoilt);
    EXPECT_EQ(controller_.executed(3), 1);
    EXPECT_EQ(machine().link_stats().stale, 1U);
    EXPECT_EQ(machine().link_stats().timeouts, 1U);
}

TEST_F(RtuFault, AStopDoesNotWaitForAReplyThatDoesNotCome) {
    settings_.response_timeout_ms = 50'000.0;
    controller_.with_machine([](test::ScriptedMachine& machine) {
        machine.set_register(25, 10'000, true);  // a patient watchdog, so that the lost reply is waited for
        machine.motions_take(1'000'000);
    });
    link_to(settings_);
    begin();
    std::atomic<bool> mute{false}, muted{false};
    controller_.on_request([&](const Request& request) {
        if (!mute || request.function == 6) return Fault::none;
        muted = true;
        return Fault::silent;
    });
    const auto homing = rig_->start(machine().home());
    ASSERT_TRUE(rig_->wait([&] { return controller_.executed(3) == 1; }));
    mute = true;
    ASSERT_TRUE(rig_->wait([&] { return muted.load(); }));
    const auto asked = std::chrono::steady_clock::now();
    machine().stop(StopKind::controlled);
    const auto stop_value = [&] { return controller_.with_machine([](const auto& m) { return m.stop_value(); }); };
    ASSERT_TRUE(rig_->wait([&] { return stop_value() == 1; }));
    const auto arrived = controller_.with_machine([](const auto& m) { return m.stop_arrived(); });
    const double ms = std::chrono::duration<double, std::milli>(arrived - asked).count();
    std::printf("stop at the controller %.1f ms after the request, with a transaction in flight\n", ms);
    RecordProperty("stop_ms", std::to_string(ms));
    mute = false;
    ASSERT_TRUE(rig_->wait([&] { return homing->done(); }));
    EXPECT_FALSE(*homing->result);
}

TEST_F(RtuFault, AStopWhoseReplyIsLostIsSentAgain) {
    begin();
    std::atomic<int> stops{0};
    controller_.on_request(
        [&](const Request& request) { return request.function == 6 && ++stops < 3 ? Fault::silent : Fault::none; });
    machine().stop(StopKind::emergency);
    ASSERT_TRUE(
        rig_->wait([&] { return controller_.with_machine([](const auto& m) { return m.stop_value(); }) == 2; }));
    EXPECT_EQ(stops, 3);
}

TEST_F(RtuFault, AnAdapterThatIsPulledAndPutBackIsFoundAgain) {
    begin();
    wire_.unplug_host();
    const auto lost = rig_->run(machine().state());
    ASSERT_FALSE(lost);
    EXPECT_EQ(core::exit_code(lost.error().code), 5) << lost.error().text();
    EXPECT_NE(lost.error().text().find(wire_.host()), std::string::npos) << lost.error().text();
    wire_.plug_host();
    const auto state = rig_->run(machine().state());
    EXPECT_TRUE(state) << state.error().text();
    EXPECT_TRUE(rig_->run(machine().home()));
}

TEST_F(RtuFault, NobodyOnTheLineIsSaidSo) {
    controller_.on_request([](const Request&) { return Fault::silent; });
    const auto found = rig_->run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::transport_timeout);
    EXPECT_NE(found.error().text().find("baud, parity and unit"), std::string::npos) << found.error().text();
}

TEST_F(RtuFault, ALineTooSlowForTheWatchdogIsRefused) {
    link_to(test::settings_for("modbus+rtu://" + wire_.host() + "?baud=9600"));
    const auto found = rig_->run(machine().connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::protocol_mismatch);
    EXPECT_NE(found.error().text().find("raise the baud rate"), std::string::npos) << found.error().text();
}

TEST(RtuPort, APortThatIsNotThereIsNamed) {
    MachineRig rig(test::settings_for("modbus+rtu:///dev/no-such-port"));
    const auto found = rig.run(rig.machine->connect());
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().code, core::ErrorCode::transport_connect);
    EXPECT_NE(found.error().text().find("/dev/no-such-port"), std::string::npos);
}

}  // namespace
}  // namespace cmm::drivers
