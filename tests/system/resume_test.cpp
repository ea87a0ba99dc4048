// SPDX-License-Identifier: Apache-2.0
// The host is killed in the middle of a scan, again and again. Judge: the simulator's own log of every sample it
// recorded.
#include <gtest/gtest.h>

#include <chrono>

#include "core/rng.hpp"
#include "tests/system/resumable_run.hpp"
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

class Resume : public testing::TestWithParam<const char*> {};

TEST_P(Resume, AKilledHostLosesNothingAndDoublesNothing) {
    const TemporaryFolder folder;
    const std::string part = GetParam();
    const std::string out = folder / "out";
    SimulatedMachine machine(part, folder, {"--speed", "10", "--seed", "3"});
    ASSERT_FALSE(machine.url().empty()) << machine.process().out();
    core::Rng rng(2026);
    int kills = 0;
    for (int attempt = 0; attempt < 20; ++attempt) {
        const auto before = log_size(machine);
        Process scan(scan_command(machine, part, out, attempt > 0), folder / ("scan-" + std::to_string(attempt)));
        // From the first new samples on, at a random instant.
        ASSERT_TRUE(
            wait_for([&] { return !scan.running() || log_size(machine) > before + 400; }, std::chrono::seconds(60)));
        if (wait_for([&] { return !scan.running(); }, std::chrono::milliseconds(1 + rng.below(250)))) {
            const auto finished = scan.wait(std::chrono::seconds(1));
            if (finished.exit_code == 0) break;
            ADD_FAILURE() << "attempt " << attempt << " ended by itself with " << finished.exit_code << ": "
                          << finished.err;
            return;
        }
        scan.signal(SIGKILL);
        scan.wait(std::chrono::seconds(5));
        ++kills;
    }
    EXPECT_GE(kills, 10);
    ASSERT_TRUE(machine.process().running()) << "the simulator did not survive";
    const auto last =
        Process(scan_command(machine, part, out, true), folder / "scan-last").wait(std::chrono::seconds(120));
    EXPECT_EQ(last.exit_code, 0) << last.err << last.out;
    machine.end();
    expect_every_sample_once(out + "/run.cmmrun", machine.log());
}

INSTANTIATE_TEST_SUITE_P(Parts, Resume, testing::Values("config/parts/demo.toml", "tests/system/parts/unknown.toml"),
                         [](const auto& tested) { return std::string(tested.index == 0 ? "Nominal" : "Unknown"); });

TEST(Resume, AnUnknownSectionThatWasMeasuredWhollyIsNotScannedAgain) {
    const TemporaryFolder folder;
    const std::string part = "tests/system/parts/unknown.toml", out = folder / "out", run = out + "/run.cmmrun";
    SimulatedMachine machine(part, folder, {"--speed", "0", "--seed", "3"});
    const auto whole =
        Process(scan_command(machine, part, out, false), folder / "whole").wait(std::chrono::seconds(120));
    ASSERT_EQ(whole.exit_code, 0) << whole.err;
    // As a host leaves it that is killed between the last sample and the note of it.
    const std::string forget = "UPDATE path SET finished = 0 WHERE path = (SELECT max(path) FROM path)";
    ASSERT_EQ(Process({"sqlite3", run, forget}, folder / "forget").wait(std::chrono::seconds(10)).exit_code, 0);
    const auto resumed =
        Process(scan_command(machine, part, out, true), folder / "resumed").wait(std::chrono::seconds(120));
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    machine.end();
    expect_every_sample_once(run, machine.log());
}

TEST(Resume, TheMachineStopsByItsWatchdogWhenTheHostDies) {
    const TemporaryFolder folder;
    SimulatedMachine machine("config/parts/demo.toml", folder, {"--speed", "2"});
    Process scan(scan_command(machine, "config/parts/demo.toml", folder / "out", false), folder / "scan");
    ASSERT_TRUE(wait_for([&] { return log_size(machine) > 5000; }));
    scan.signal(SIGKILL);
    SeenState seen;
    EXPECT_TRUE(wait_for([&] { return (seen = state_of(machine)).state == "stopped"; })) << seen.state;
    EXPECT_NE(seen.fault.find("watchdog"), std::string::npos) << seen.fault;
}

TEST(Resume, RefusesARunThatIsNotThereAndARunThatIs) {
    const TemporaryFolder folder;
    const auto absent = run({cmmlive(), "scan", "--machine", "modbus+tcp://127.0.0.1:9", "--part",
                             "config/parts/demo.toml", "--out", folder / "none", "--resume"});
    EXPECT_EQ(absent.exit_code, 3);
    EXPECT_NE(absent.err.find("no run to resume"), std::string::npos) << absent.err;
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--out", folder / "done"}).exit_code, 0);
    const auto present = run({cmmlive(), "scan", "--machine", "modbus+tcp://127.0.0.1:9", "--part",
                              "config/parts/demo.toml", "--out", folder / "done"});
    EXPECT_EQ(present.exit_code, 3);
    EXPECT_NE(present.err.find("--resume"), std::string::npos) << present.err;
}

}  // namespace
}  // namespace cmm::test
