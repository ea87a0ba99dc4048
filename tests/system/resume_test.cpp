// SPDX-License-Identifier: Apache-2.0
// The host is killed in the middle of a scan, again and again. Judge: the simulator's own log of every sample it
// recorded.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>

#include "acquisition/journal.hpp"
#include "core/rng.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

std::vector<std::string> scan_command(const SimulatedMachine& machine, const std::string& part, const std::string& out,
                                      bool resume) {
    std::vector<std::string> arguments{cmmlive(), "scan", "--machine", machine.url(), "--part", part, "--out", out};
    if (resume) arguments.emplace_back("--resume");
    return arguments;
}

/// Every sample in the run file, exactly once, with the counts that the simulator logged.
void expect_every_sample_once(const std::string& run_file, const std::string& log_file) {
    auto journal = acquisition::Journal::read(run_file);
    ASSERT_TRUE(journal) << journal.error().text();
    const auto samples = (*journal)->samples();
    ASSERT_TRUE(samples) << samples.error().text();
    const auto log = read_csv(log_file);
    ASSERT_FALSE(log.empty());
    const std::int64_t shift = (*journal)->header().sequence_shift;
    ASSERT_EQ(samples->size(), log.size());
    for (std::size_t i = 0; i < log.size(); ++i) {
        ASSERT_EQ((*samples)[i].sequence, i + 1);
        ASSERT_EQ(static_cast<std::int64_t>((*samples)[i].sequence) - shift, std::stoll(log[i].at("seq")));
        ASSERT_EQ((*samples)[i].counts[0], std::stoi(log[i].at("x_counts")));
        ASSERT_EQ((*samples)[i].counts[1], std::stoi(log[i].at("y_counts")));
        ASSERT_EQ((*samples)[i].counts[2], std::stoi(log[i].at("z_counts")));
    }
}

class Resume : public testing::TestWithParam<const char*> {};

TEST_P(Resume, AKilledHostLosesNothingAndDoublesNothing) {
    const TemporaryFolder folder;
    const std::string part = GetParam();
    const std::string out = folder / "out";
    SimulatedMachine machine(part, folder, {"--speed", "10", "--seed", "3"});
    ASSERT_FALSE(machine.url().empty()) << machine.process().out();
    core::Rng rng(2026);
    int kills = 0;
    const auto log_size = [&] {
        std::error_code ignored;
        const auto size = std::filesystem::file_size(machine.log(), ignored);
        return ignored ? std::uintmax_t{0} : size;
    };
    for (int attempt = 0; attempt < 20; ++attempt) {
        const auto before = log_size();
        Process scan(scan_command(machine, part, out, attempt > 0), folder / ("scan-" + std::to_string(attempt)));
        // From the first new samples on, at a random instant.
        ASSERT_TRUE(wait_for([&] { return !scan.running() || log_size() > before + 400; }, std::chrono::seconds(60)));
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

TEST(Resume, TheMachineStopsByItsWatchdogWhenTheHostDies) {
    const TemporaryFolder folder;
    SimulatedMachine machine("config/parts/demo.toml", folder, {"--speed", "2"});
    Process scan(scan_command(machine, "config/parts/demo.toml", folder / "out", false), folder / "scan");
    ASSERT_TRUE(wait_for([&] { return read_csv(machine.log()).size() > 50; }));
    scan.signal(SIGKILL);
    std::string state;
    const bool stopped = wait_for(
        [&] {
            const auto doctor = run({cmmlive(), "doctor", "--machine", machine.url(), "--json"});
            const auto document = nlohmann::json::parse(doctor.out, nullptr, false);
            if (document.is_discarded() || !document.contains("machine")) return false;
            state = document["machine"]["state"];
            return state == "stopped";
        },
        std::chrono::seconds(5));
    EXPECT_TRUE(stopped) << state;
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
