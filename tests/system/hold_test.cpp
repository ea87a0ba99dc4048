// SPDX-License-Identifier: Apache-2.0
// A job that waits at rest: how it is ended, and a disk that is really full. That nothing is lost is the fault
// matrix's.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr const char* held_part = "tests/system/parts/fault-job.toml";

class Hold : public testing::Test {
  protected:
    /// A machine whose door opens in the first section and stays open.
    void open_door() {
        const std::string plan = folder_ / "faults.toml";
        std::ofstream(plan) << "[[fault]]\nwhat = \"door\"\nsamples = 60\n";
        machine_ = std::make_unique<SimulatedMachine>(held_part, folder_,
                                                      std::vector<std::string>{"--speed", "20", "--faults", plan});
        ASSERT_FALSE(machine_->url().empty()) << machine_->process().err();
    }
    std::unique_ptr<Process> scan(const std::string& wait_s) {
        auto command = scan_command(*machine_, held_part, out_, false);
        command.insert(command.end(), {"--wait-s", wait_s, "--events", folder_ / "events"});
        return std::make_unique<Process>(command, folder_ / "scan");
    }
    static bool waits(const Process& scan) { return scan.err().find("waiting at rest") != std::string::npos; }

    TemporaryFolder folder_;
    std::string out_ = folder_ / "out";
    std::unique_ptr<SimulatedMachine> machine_;
};

TEST_F(Hold, CtrlCEndsTheWaiting) {
    open_door();
    const auto job = scan("100");
    ASSERT_TRUE(wait_for([&] { return waits(*job); })) << job->err();
    EXPECT_EQ(state_of(*machine_).state, "stopped");
    EXPECT_TRUE(job->running());
    job->signal(SIGINT);
    const auto ended = job->wait(std::chrono::seconds(20));
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("stopped on request"), std::string::npos) << ended.err;
}

TEST_F(Hold, ItEndsWithTheReasonWhenTheTimeIsOver) {
    open_door();
    const auto ended = scan("1")->wait(std::chrono::seconds(60));
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("a door is open"), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("(waited "), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("Close the door"), std::string::npos) << ended.err;
    std::ifstream in(folder_ / "events");
    const std::string events(std::istreambuf_iterator<char>(in), {});
    EXPECT_NE(events.find("\"event\":\"Hold\""), std::string::npos);
}

TEST_F(Hold, AnUnknownSectionGoesOnWhereItWas) {
    const std::string unknown = "tests/system/parts/unknown.toml", plan = folder_ / "faults.toml";
    std::ofstream(plan) << "[[fault]]\nwhat = \"door\"\nsamples = 170\nfor_s = 0.3\n";
    machine_ = std::make_unique<SimulatedMachine>(unknown, folder_,
                                                  std::vector<std::string>{"--speed", "10", "--faults", plan});
    const auto ended =
        Process(scan_command(*machine_, unknown, out_, false), folder_ / "scan").wait(std::chrono::seconds(60));
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_NE(ended.err.find("waiting at rest, up to 300 s"), std::string::npos) << ended.err;
    machine_->end();
    expect_every_sample_once(out_ + "/run.cmmrun", machine_->log());
}

TEST_F(Hold, AFullDiskThatIsEmptiedIsWaitedFor) {
    const std::string disk = folder_ / "disk";
    const auto mounted = run({"sh", "-c", "mkdir " + disk + " && mount -t tmpfs -o size=3m tmpfs " + disk});
    if (mounted.exit_code != 0) GTEST_SKIP() << "no right to mount a small disk: " << mounted.err;
    {
        machine_ = std::make_unique<SimulatedMachine>(held_part, folder_, std::vector<std::string>{"--speed", "20"});
        // 110 KB are left: enough to begin the run file, not for the run.
        EXPECT_EQ(run({"fallocate", "-l", std::to_string((3 * 1024 - 110) * 1024), disk + "/other"}).exit_code, 0);
        auto command = scan_command(*machine_, held_part, disk + "/out", false);
        command.insert(command.end(), {"--wait-s", "100"});
        Process job(command, folder_ / "scan");
        EXPECT_TRUE(wait_for([&] { return waits(job) || !job.running(); }));
        EXPECT_TRUE(waits(job)) << job.err();
        std::filesystem::remove(disk + "/other");
        const auto ended = job.wait(std::chrono::seconds(60));
        EXPECT_EQ(ended.exit_code, 0) << ended.err;
        machine_->end();
        expect_every_sample_once(disk + "/out/run.cmmrun", machine_->log());
    }
    run({"umount", disk});
}

}  // namespace
}  // namespace cmm::test
