// SPDX-License-Identifier: Apache-2.0
// The probe is moved back after it ran into something, and stays where it is after an emergency stop.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <memory>

#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr const char* part = "tests/system/parts/fault-job.toml";
constexpr double lsb_mm = 1e-4;  // config/machines/sim.toml

struct Place {
    double x, y, z;
};
double distance(const Place& a, const Place& b) {
    return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
}

class RetractNever : public testing::Test {
  protected:
    void scan_until(const std::string& fault) {
        const std::string plan = folder_ / "faults.toml";
        std::ofstream(plan) << "[[fault]]\nwhat = \"" << fault << "\"\nsamples = 60\n";
        machine_ = std::make_unique<SimulatedMachine>(part, folder_,
                                                      std::vector<std::string>{"--speed", "20", "--faults", plan});
        ASSERT_FALSE(machine_->url().empty()) << machine_->process().err();
        ended_ = Process(scan_command(*machine_, part, out_, false), folder_ / "scan").wait(std::chrono::seconds(60));
        EXPECT_EQ(ended_.exit_code, 4) << ended_.err;
        const auto doctor = run({cmmlive(), "doctor", "--machine", machine_->url(), "--json"});
        const auto document = nlohmann::json::parse(doctor.out, nullptr, false);
        ASSERT_TRUE(document.contains("machine")) << doctor.out << doctor.err;
        const auto& at = document["machine"]["position_mm"];
        stands_ = {at[0], at[1], at[2]};
        in_contact_ = document["machine"]["in_contact"];
    }
    /// Of the sample that was recorded last.
    Place measured_last() const {
        const auto row = read_csv(machine_->log()).back();
        return {std::stoi(row.at("x_counts")) * lsb_mm, std::stoi(row.at("y_counts")) * lsb_mm,
                std::stoi(row.at("z_counts")) * lsb_mm};
    }

    TemporaryFolder folder_;
    std::string out_ = folder_ / "out";
    std::unique_ptr<SimulatedMachine> machine_;
    Finished ended_;
    Place stands_{};
    bool in_contact_ = true;
};

class Retract : public RetractNever, public testing::WithParamInterface<const char*> {};

TEST_P(Retract, TheProbeIsLedOffThePartAndTheRunCanGoOn) {
    ASSERT_NO_FATAL_FAILURE(scan_until(GetParam()));
    EXPECT_NE(ended_.err.find("(the probe was moved back 1.000 mm)"), std::string::npos) << ended_.err;
    EXPECT_FALSE(in_contact_);
    const auto resumed =
        Process(scan_command(*machine_, part, out_, true), folder_ / "resumed").wait(std::chrono::seconds(60));
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
    EXPECT_TRUE(in_contact_);
    machine_->end();
    EXPECT_LT(distance(stands_, measured_last()), 1.5);  // a step of the path
}

TEST_F(RetractNever, AfterALostPosition) {
    ASSERT_NO_FATAL_FAILURE(scan_until("encoder_jump"));
    EXPECT_EQ(ended_.err.find("moved back"), std::string::npos) << ended_.err;
    EXPECT_TRUE(in_contact_);
}

}  // namespace
}  // namespace cmm::test
