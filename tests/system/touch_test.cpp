// SPDX-License-Identifier: Apache-2.0
// Sections measured by single touches on the simulated machine: as good as scanned, and after the host was killed every
// place once.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "acquisition/journal.hpp"
#include "core/rng.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

constexpr const char* planned_part = "tests/system/parts/touched.toml";
constexpr const char* touched_unknown_part = "tests/system/parts/touched-unknown.toml";

std::vector<std::string> touch_command(const SimulatedMachine& machine, const std::string& part, const std::string& out,
                                       bool resume) {
    auto command = scan_command(machine, part, out, resume);
    if (!resume) command.emplace_back("--touch");  // a run goes on as it began
    return command;
}

/// Points of sections in a run file: what the machine gave for a path of ours.
std::size_t section_points(const std::string& out) {
    auto journal = acquisition::Journal::read(out + "/run.cmmrun");
    if (!journal) return 0;
    const auto samples = (*journal)->samples().value();
    return static_cast<std::size_t>(std::count_if(samples.begin(), samples.end(), core::of_section));
}

/// Largest distance of a contour to the other, mm.
double apart_mm(const std::string& out, const std::string& other) {
    std::vector<Eigen::Vector2d> closed;
    for (const auto& row : read_contour(other + "/section-0.csv"))
        closed.emplace_back(row.position_mm.head<2>());
    double worst = 0.0;
    const auto contour = read_contour(out + "/section-0.csv");
    for (std::size_t i = 0; i < contour.size(); i += 7)
        worst = std::max(worst, distance_to_polyline(contour[i].position_mm.head<2>(), closed));
    return contour.empty() || closed.empty() ? 1e9 : worst;
}

class Touch : public testing::TestWithParam<const char*> {};

TEST_P(Touch, AsGoodAsAScan) {
    const TemporaryFolder folder;
    const std::string part = GetParam(), touched = folder / "touched", scanned = folder / "scanned";
    SimulatedMachine machine(part, folder, {"--speed", "0", "--seed", "3"});
    ASSERT_FALSE(machine.url().empty()) << machine.process().out();
    const auto by_touch =
        Process(touch_command(machine, part, touched, false), folder / "t").wait(std::chrono::seconds(120));
    ASSERT_EQ(by_touch.exit_code, 0) << by_touch.err << by_touch.out;
    const auto by_scan =
        Process(scan_command(machine, part, scanned, false), folder / "s").wait(std::chrono::seconds(120));
    ASSERT_EQ(by_scan.exit_code, 0) << by_scan.err << by_scan.out;
    if (part == planned_part) {
        EXPECT_EQ(section_points(touched), section_points(scanned));
    }
    EXPECT_LT(apart_mm(touched, scanned), 0.02);
    // What was recorded by touches is played as a scan.
    const auto played = run({cmmlive(), "replay", touched, "--out", folder / "played"}, std::chrono::seconds(60));
    EXPECT_EQ(played.exit_code, 0) << played.err;
    EXPECT_EQ(apart_mm(folder / "played", touched), 0.0);
}

TEST_P(Touch, AKilledHostLosesNothingAndTouchesNoPlaceTwice) {
    const TemporaryFolder folder;
    const std::string part = GetParam(), out = folder / "out";
    SimulatedMachine machine(part, folder, {"--speed", "30", "--seed", "3"});
    ASSERT_FALSE(machine.url().empty()) << machine.process().out();
    core::Rng rng(2026);
    for (int attempt = 0; attempt < 5; ++attempt) {
        const auto before = log_size(machine);
        Process scan(touch_command(machine, part, out, attempt > 0), folder / ("scan-" + std::to_string(attempt)));
        ASSERT_TRUE(
            wait_for([&] { return !scan.running() || log_size(machine) > before + 800; }, std::chrono::seconds(60)));
        ASSERT_FALSE(wait_for([&] { return !scan.running(); }, std::chrono::milliseconds(1 + rng.below(100))))
            << scan.err();
        scan.signal(SIGKILL);
        scan.wait(std::chrono::seconds(5));
    }
    const auto last = Process(touch_command(machine, part, out, true), folder / "last").wait(std::chrono::seconds(120));
    EXPECT_EQ(last.exit_code, 0) << last.err << last.out;
    machine.end();
    expect_every_sample_once(out + "/run.cmmrun", machine.log());
    if (part != planned_part) return;
    // All of them points of the section, as many as the plan has places.
    const auto plan = run({cmmlive(), "plan", "--part", part, "--json"});
    EXPECT_EQ(section_points(out), read_csv(machine.log()).size());
    EXPECT_NE(plan.out.find(std::to_string(section_points(out)) + " points"), std::string::npos) << plan.out;
}

INSTANTIATE_TEST_SUITE_P(Parts, Touch, testing::Values(planned_part, touched_unknown_part),
                         [](const auto& tested) { return std::string(tested.index == 0 ? "Nominal" : "Unknown"); });

}  // namespace
}  // namespace cmm::test
