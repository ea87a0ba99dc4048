// SPDX-License-Identifier: Apache-2.0
// Ctrl-C in the middle of a scan: once, and twice by somebody who does not want to wait.
#include <gtest/gtest.h>

#include <csignal>
#include <memory>

#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr const char* interrupted_part = "config/parts/demo.toml";

class Interrupt : public testing::Test {
  protected:
    /// A scan with its first samples taken.
    void begin_scan() {
        ASSERT_FALSE(machine_.url().empty()) << machine_.process().out();
        scan_ = std::make_unique<Process>(scan_command(machine_, interrupted_part, out_, false), folder_ / "scan");
        ASSERT_TRUE(wait_for([&] { return log_size(machine_) > 5000; }));
    }
    void expect_stopped_by_request() {
        SeenState seen;
        EXPECT_TRUE(wait_for([&] { return (seen = state_of(machine_)).state == "stopped"; })) << seen.state;
        EXPECT_EQ(seen.fault.find("watchdog"), std::string::npos) << seen.fault;
    }
    void expect_resumable() {
        const auto rest = Process(scan_command(machine_, interrupted_part, out_, true), folder_ / "resumed")
                              .wait(std::chrono::seconds(120));
        EXPECT_EQ(rest.exit_code, 0) << rest.err << rest.out;
        machine_.end();
        expect_every_sample_once(out_ + "/run.cmmrun", machine_.log());
    }

    TemporaryFolder folder_;
    std::string out_ = folder_ / "out";
    SimulatedMachine machine_{interrupted_part, folder_, {"--speed", "10"}};
    std::unique_ptr<Process> scan_;
};

TEST_F(Interrupt, OnceStopsTheMachineAndLeavesARunToGoOnWith) {
    begin_scan();
    scan_->signal(SIGINT);
    const auto ended = scan_->wait(std::chrono::seconds(30));
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("stopped on request"), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("--resume"), std::string::npos) << ended.err;
    expect_stopped_by_request();
    expect_resumable();
}

TEST_F(Interrupt, TwiceDoesNotWaitButStopsTheMachineAllTheSame) {
    begin_scan();
    // Two different signals: equal ones that are pending become one.
    scan_->signal(SIGINT);
    scan_->signal(SIGTERM);
    const auto ended = scan_->wait(std::chrono::seconds(30));
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("aborted; the machine was told to stop"), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("--resume"), std::string::npos) << ended.err;
    expect_stopped_by_request();
    expect_resumable();
}

TEST_F(Interrupt, TwiceEndsAlsoWhenTheControllerHangs) {
    begin_scan();
    machine_.process().signal(SIGSTOP);
    scan_->signal(SIGINT);
    scan_->signal(SIGTERM);
    const auto ended = scan_->wait(std::chrono::seconds(30));
    machine_.process().signal(SIGCONT);
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("aborted"), std::string::npos) << ended.err;
    SeenState seen;
    EXPECT_TRUE(wait_for([&] { return (seen = state_of(machine_)).state == "stopped"; })) << seen.state;
    expect_resumable();
}

}  // namespace
}  // namespace cmm::test
