// SPDX-License-Identifier: Apache-2.0
// The driver on a pseudo-terminal, the test at its other end.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "machine_rig.hpp"
#include "tests/support/serial_wire.hpp"

namespace cmm::drivers {
namespace {

using test::MachineRig;

class HandLog final : public HandSink {
  public:
    core::Status on_samples(std::span<const core::Sample> samples) override {
        kept.insert(kept.end(), samples.begin(), samples.end());
        return {};
    }
    std::uint64_t durable_sequence() const noexcept override { return kept.size(); }
    core::Result<bool> hasten() override { return true; }
    void on_garbled(std::string_view line, std::string_view /*why*/) override { garbled.emplace_back(line); }

    std::vector<core::Sample> kept;
    std::vector<std::string> garbled;
};

/// A readout's end of the wire.
class Readout {
  public:
    explicit Readout(const std::string& port) : fd_(::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)) {}
    ~Readout() { ::close(fd_); }
    Readout(const Readout&) = delete;
    Readout& operator=(const Readout&) = delete;
    void print(const std::string& text) const {
        ASSERT_EQ(::write(fd_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
    }
    std::string heard() const {
        std::array<char, 256> bytes{};
        const auto count = ::read(fd_, bytes.data(), bytes.size());
        return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0))};
    }

  private:
    int fd_;
};

struct DroMachineTest : testing::Test {
    cmm::test::SerialWire wire;
    Readout readout{wire.device()};
    LinkSettings settings = test::settings_for("dro+serial://" + wire.host() + "?baud=9600");
    HandLog log;
};

TEST_F(DroMachineTest, DeliversPointsUntilItIsToldThatTheSectionEnds) {
    MachineRig rig(settings);
    Machine& machine = *rig.machine;
    const auto found = rig.run(machine.connect());
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_FALSE(found->moves);
    EXPECT_DOUBLE_EQ(found->lsb_mm, 1e-4);
    ASSERT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    const auto taken = rig.start(machine.receive(ScanPath{.id = 3}, log));
    readout.print("X1.0000,Y2.0000,Z3.0000\r\nX1.0000,Y2.");
    ASSERT_TRUE(rig.wait([&] { return log.kept.size() == 1; }));
    const auto second = rig.run(machine.receive(ScanPath{.id = 4}, log));
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, core::ErrorCode::machine_busy);
    readout.print("5000,Z3.0000\nnoise\nX1.0000,Y3.0000,Z-3.0000\r");
    ASSERT_TRUE(rig.wait([&] { return log.kept.size() == 3; }));
    machine.tell(HandSignal::end_section);
    ASSERT_TRUE(rig.wait([&] { return taken->done(); }));
    ASSERT_TRUE(*taken->result);
    EXPECT_EQ((*taken->result)->points_passed, 3U);
    EXPECT_EQ((*taken->result)->last_sequence, 3U);
    for (std::size_t k = 0; k < log.kept.size(); ++k) {
        EXPECT_EQ(log.kept[k].sequence, k + 1);
        EXPECT_EQ(log.kept[k].path, 3);
        EXPECT_EQ(log.kept[k].counts[0], 10000);
        EXPECT_GT(log.kept[k].host_time_ns, 0);
        EXPECT_GE(log.kept[k].machine_time_us, k > 0 ? log.kept[k - 1].machine_time_us : 0);
    }
    EXPECT_EQ(log.kept[1].counts[1], 25000);
    EXPECT_EQ(log.garbled, std::vector<std::string>{"noise"});
    EXPECT_EQ(machine.link_stats().invalid, 1U);

    // What comes between two sections is the next one's.
    readout.print("X7.0000,Y8.0000,Z9.0000\r\n");
    const auto next = rig.start(machine.receive(ScanPath{.id = 4}, log));
    ASSERT_TRUE(rig.wait([&] { return log.kept.size() == 4; }));
    EXPECT_EQ(log.kept[3].path, 4);
    machine.stop(StopKind::controlled);
    ASSERT_TRUE(rig.wait([&] { return next->done(); }));
    EXPECT_TRUE(*next->result);
}

TEST_F(DroMachineTest, CannotMove) {
    MachineRig rig(settings);
    Machine& machine = *rig.machine;
    ASSERT_TRUE(rig.run(machine.connect()));
    ASSERT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    const auto path = test::circle_path(5.0, 0.0, 8, 1.0);
    PointList source(path);
    const auto scanned = rig.run(machine.scan(ScanPath{}, source, log));
    ASSERT_FALSE(scanned);
    for (const auto& error : {rig.run(machine.home()).error(), rig.run(machine.qualify(1.0)).error(),
                              rig.run(machine.move({1.0, 2.0, 3.0}, 5.0)).error(), scanned.error(),
                              rig.run(machine.touch({1.0, 2.0, 3.0}, 5.0, 1.0, log)).error()}) {
        EXPECT_EQ(error.code, core::ErrorCode::machine_refused);
        EXPECT_NE(error.message.find("cannot move"), std::string::npos) << error.message;
    }
    EXPECT_TRUE(rig.run(machine.state())->homed);
}

TEST_F(DroMachineTest, AsksForAPointWhenAPersonWantsOne) {
    settings.dro.request = "P\r";
    settings.dro.end = "END";
    MachineRig rig(settings);
    Machine& machine = *rig.machine;
    ASSERT_TRUE(rig.run(machine.connect()));
    ASSERT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    const auto taken = rig.start(machine.receive(ScanPath{}, log));
    machine.tell(HandSignal::take_point);
    std::string heard;
    ASSERT_TRUE(rig.wait([&] { return (heard += readout.heard()) == "P\r"; })) << heard;
    readout.print("X1.0000,Y2.0000,Z3.0000\r\nEND\r\n");
    ASSERT_TRUE(rig.wait([&] { return taken->done(); }));
    EXPECT_EQ(log.kept.size(), 1U);
}

TEST_F(DroMachineTest, APlugThatIsPulledAndPutBackLosesOnlyTheBrokenLine) {
    settings.reconnect_ms = 20'000.0;
    MachineRig rig(settings);
    Machine& machine = *rig.machine;
    ASSERT_TRUE(rig.run(machine.connect()));
    ASSERT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    const auto taken = rig.start(machine.receive(ScanPath{}, log));
    readout.print("X1.0000,Y2.0000,Z3.0000\r\nX1.0");
    ASSERT_TRUE(rig.wait([&] { return log.kept.size() == 1; }));
    wire.unplug_host();
    wire.plug_host();
    ASSERT_TRUE(rig.wait([&] { return machine.link_stats().reconnects == 1; }));
    readout.print("X4.0000,Y5.0000,Z6.0000\r\n");
    ASSERT_TRUE(rig.wait([&] { return log.kept.size() == 2; }));
    EXPECT_EQ(log.kept[1].sequence, 2U);
    EXPECT_EQ(log.kept[1].counts[0], 40000);
    wire.unplug_host();
    machine.tell(HandSignal::end_section);
    ASSERT_TRUE(rig.wait([&] { return taken->done(); }));
}

TEST_F(DroMachineTest, APortThatStaysAwayEndsTheSectionWithAnError) {
    settings.reconnect_ms = 50.0;
    MachineRig rig(settings);
    Machine& machine = *rig.machine;
    ASSERT_TRUE(rig.run(machine.connect()));
    ASSERT_TRUE(rig.run(machine.begin_run(std::nullopt)));
    const auto taken = rig.start(machine.receive(ScanPath{}, log));
    wire.unplug_host();
    ASSERT_TRUE(rig.wait([&] { return taken->done(); }));
    ASSERT_FALSE(*taken->result);
    EXPECT_EQ(taken->result->error().code, core::ErrorCode::transport_closed);
}

}  // namespace
}  // namespace cmm::drivers
