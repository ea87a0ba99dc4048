// SPDX-License-Identifier: Apache-2.0
// The probe is moved back after it ran into something, and stays where it is after an emergency stop.
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <memory>

#include "core/text.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr const char* retracted_part = "tests/system/parts/fault-job.toml";
constexpr double lsb_mm = 1e-4;  // config/machines/sim.toml

struct Place {
    double x, y, z;
};
double distance(const Place& a, const Place& b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

/// Of the sample that was recorded last.
Place measured_last(const SimulatedMachine& machine) {
    const auto row = read_csv(machine.log()).back();
    return {std::stoi(row.at("x_counts")) * lsb_mm, std::stoi(row.at("y_counts")) * lsb_mm,
            std::stoi(row.at("z_counts")) * lsb_mm};
}

/// Where the machine stands, and whether in contact, as `cmmlive doctor` tells.
struct Standing {
    Place at{};
    bool in_contact = true;
};
Standing standing(const SimulatedMachine& machine) {
    const auto doctor = run({cmmlive(), "doctor", "--machine", machine.url(), "--json"});
    const auto document = nlohmann::json::parse(doctor.out, nullptr, false);
    EXPECT_TRUE(document.contains("machine")) << doctor.out << doctor.err;
    if (!document.contains("machine")) return {};
    const auto& at = document["machine"]["position_mm"];
    return {{at[0], at[1], at[2]}, document["machine"]["in_contact"]};
}

class RetractNever : public testing::Test {
  protected:
    void scan_until(const std::string& fault) {
        const std::string plan = folder_ / "faults.toml";
        std::ofstream(plan) << "[[fault]]\nwhat = \"" << fault << "\"\nsamples = 60\n";
        machine_ = std::make_unique<SimulatedMachine>(retracted_part, folder_,
                                                      std::vector<std::string>{"--speed", "20", "--faults", plan});
        ASSERT_FALSE(machine_->url().empty()) << machine_->process().err();
        ended_ = Process(scan_command(*machine_, retracted_part, out_, false), folder_ / "scan")
                     .wait(std::chrono::seconds(60));
        EXPECT_EQ(ended_.exit_code, 4) << ended_.err;
        stands_ = standing(*machine_);
    }
    TemporaryFolder folder_;
    std::string out_ = folder_ / "out";
    std::unique_ptr<SimulatedMachine> machine_;
    Finished ended_;
    Standing stands_;
};

class Retract : public RetractNever, public testing::WithParamInterface<const char*> {};

TEST_P(Retract, TheProbeIsLedOffThePartAndTheRunCanGoOn) {
    ASSERT_NO_FATAL_FAILURE(scan_until(GetParam()));
    EXPECT_NE(ended_.err.find("(the probe was moved back 1.000 mm)"), std::string::npos) << ended_.err;
    EXPECT_FALSE(stands_.in_contact);
    const auto resumed = Process(scan_command(*machine_, retracted_part, out_, true), folder_ / "resumed")
                             .wait(std::chrono::seconds(60));
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    machine_->end();
    expect_every_sample_once(out_ + "/run.cmmrun", machine_->log());
}

INSTANTIATE_TEST_SUITE_P(Faults, Retract, testing::Values("over_deflection", "collision"), [](const auto& tested) {
    return std::string(tested.index == 0 ? "OverDeflection" : "Collision");
});

TEST_F(RetractNever, AfterAnEmergencyStop) {
    ASSERT_NO_FATAL_FAILURE(scan_until("emergency_stop"));
    EXPECT_EQ(ended_.err.find("moved back"), std::string::npos) << ended_.err;
    EXPECT_TRUE(stands_.in_contact);
    machine_->end();
    EXPECT_LT(distance(stands_.at, measured_last(*machine_)), 1.5);  // a step of the path
}

TEST_F(RetractNever, AfterALostPosition) {
    ASSERT_NO_FATAL_FAILURE(scan_until("encoder_jump"));
    EXPECT_EQ(ended_.err.find("moved back"), std::string::npos) << ended_.err;
    EXPECT_TRUE(stands_.in_contact);
}

/// The way back is 10 mm long, 5 s of the machine's time; somebody or something ends it when it has begun.
class RetractCutShort : public testing::Test {
  protected:
    void SetUp() override {
        std::string text = core::read_file(retracted_part).value();
        text.replace(text.find("[scan]\n"), 7, "[scan]\napproach_mm = 10.0\n");
        std::ofstream(job_) << text;
        const std::string plan = folder_ / "faults.toml";
        std::ofstream(plan) << "[[fault]]\nwhat = \"over_deflection\"\nsamples = 20\n";
        machine_ = std::make_unique<SimulatedMachine>(job_, folder_,
                                                      std::vector<std::string>{"--speed", "2", "--faults", plan});
        ASSERT_FALSE(machine_->url().empty()) << machine_->process().err();
        scan_ = std::make_unique<Process>(scan_command(*machine_, job_, out_, false), folder_ / "scan");
        ASSERT_TRUE(wait_for([&] { return scan_->err().find("moving the probe back 10.000 mm") != std::string::npos; },
                             std::chrono::seconds(60)))
            << scan_->err();
        ASSERT_TRUE(wait_for([&] { return state_of(*machine_).state == "moving"; })) << scan_->err();
    }
    /// The machine stands, and before the end of the way back where it was stopped on it.
    void expect_at_rest(bool on_the_way) {
        SeenState seen;
        ASSERT_TRUE(wait_for([&] {
            seen = state_of(*machine_);
            return seen.state == "stopped" || (!on_the_way && seen.state == "idle");
        })) << seen.state;
        if (!on_the_way) return;
        EXPECT_LT(distance(standing(*machine_).at, measured_last(*machine_)), 9.5);
    }
    void expect_resumable() {
        const auto rest =
            Process(scan_command(*machine_, job_, out_, true), folder_ / "resumed").wait(std::chrono::seconds(120));
        EXPECT_EQ(rest.exit_code, 0) << rest.err;
        machine_->end();
        expect_every_sample_once(out_ + "/run.cmmrun", machine_->log());
    }

    TemporaryFolder folder_;
    std::string job_ = folder_ / "job.toml", out_ = folder_ / "out";
    std::unique_ptr<SimulatedMachine> machine_;
    std::unique_ptr<Process> scan_;
};

TEST_F(RetractCutShort, ByCtrlC) {
    scan_->signal(SIGINT);
    const auto ended = scan_->wait(std::chrono::seconds(60));
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("the probe was not moved back: "), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("machine: stopped"), std::string::npos) << ended.err;
    expect_at_rest(true);
    expect_resumable();
}

TEST_F(RetractCutShort, ByTheEndOfTheHost) {
    scan_->signal(SIGKILL);
    scan_->wait(std::chrono::seconds(10));
    expect_at_rest(true);  // the watchdog's work
    expect_resumable();
}

TEST_F(RetractCutShort, ByAControllerThatFallsSilent) {
    machine_->process().signal(SIGSTOP);
    const auto ended = scan_->wait(std::chrono::seconds(60));
    machine_->process().signal(SIGCONT);
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_NE(ended.err.find("the probe was not moved back: "), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("machine: stopped"), std::string::npos) << ended.err;  // nobody knows
    expect_at_rest(false);
    expect_resumable();
}

}  // namespace
}  // namespace cmm::test
