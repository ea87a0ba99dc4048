// SPDX-License-Identifier: Apache-2.0
// A part that the first lap leaves undecided, on the simulator as a machine of its own: it is asked for more points
// over the wire until it is decided.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "acquisition/run_results.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

using acquisition::Decision;

constexpr const char* near_limit = "tests/system/parts/near-limit.toml";

class UntilDecided : public testing::Test {
  protected:
    struct Measured {
        Finished ended;
        acquisition::PartResult part;
        std::string events;
    };

    /// On a machine that is new each time: the same part with the same noise.
    Measured measure(const std::string& part, const std::string& name, const std::string& speed = "50",
                     const std::vector<std::string>& more = {}) {
        const TemporaryFolder of_machine;
        const std::string out = folder_ / name, events = folder_ / (name + "-events");
        std::vector<std::string> how{"--speed", speed, "--seed", "14"};
        how.insert(how.end(), more.begin(), more.end());
        SimulatedMachine machine(part, of_machine, how);
        EXPECT_FALSE(machine.url().empty()) << machine.process().err();
        auto command = scan_command(machine, part, out, false);
        command.insert(command.end(), {"--events", events});
        Measured measured{Process(command, folder_ / (name + "-scan")).wait(std::chrono::seconds(120)), {}, {}};
        machine.end();
        expect_every_sample_once(out + "/run.cmmrun", machine.log());
        auto result = acquisition::results_of_run(out + "/run.cmmrun", nullptr);
        EXPECT_TRUE(result) << (result ? "" : result.error().text());
        if (result) measured.part = std::move(*result);
        std::ifstream in(events);
        measured.events = {std::istreambuf_iterator<char>(in), {}};
        return measured;
    }

    /// The part without the passes: what the lap alone says.
    std::string lap_alone() {
        std::ifstream in(near_limit);
        std::string text(std::istreambuf_iterator<char>(in), {});
        for (const char* line : {"until_decided = true\n", "extra_passes = 3\n"})
            text.erase(text.find(line), std::string(line).size());
        const std::string file = folder_ / "lap.toml";
        std::ofstream(file) << text;
        return file;
    }

    static const acquisition::Characteristic& thickness(const acquisition::SectionResult& section) {
        return *section.find("max_thickness");
    }

    TemporaryFolder folder_;
};

TEST_F(UntilDecided, TheMachineMeasuresWhatDecidesAndTheLapIsKept) {
    const auto lap = measure(lap_alone(), "lap"), again = measure(near_limit, "again");
    ASSERT_EQ(lap.part.sections.size(), 1U);
    ASSERT_EQ(again.part.sections.size(), 1U);
    EXPECT_EQ(lap.ended.exit_code, 2) << lap.ended.err;
    EXPECT_EQ(lap.events.find("MeasureAgain"), std::string::npos);
    EXPECT_EQ(again.ended.exit_code, 0) << again.ended.err;
    EXPECT_NE(again.events.find("MeasureAgain"), std::string::npos);
    const auto &first = lap.part.sections[0], &second = again.part.sections[0];
    EXPECT_EQ(thickness(first).decision, Decision::undecided);
    EXPECT_EQ(thickness(second).decision, Decision::accept);
    EXPECT_LT(*thickness(second).u95, 0.8 * *thickness(first).u95);
    EXPECT_FALSE(points_of_passes(second).empty());
    // The lap's points are all there, to the last count, and so are those that were asked for.
    std::vector<acquisition::RecordedPoint> kept;
    for (const auto& point : second.points)
        if (point.pass == 0) kept.push_back(point);
    ASSERT_EQ(kept.size(), first.points.size());
    EXPECT_GT(second.points.size(), first.points.size());
    for (std::size_t i = 0; i < kept.size(); ++i)
        EXPECT_EQ(kept[i].centre_mm, first.points[i].centre_mm) << i;
}

/// The ball leaves the part for 40 places round an edge of the first section, and finds it the next time.
TEST_F(UntilDecided, WhatTheBallLostIsTouchedAgain) {
    std::ofstream(folder_ / "lift.toml")
        << "[[fault]]\nwhat = \"lift_off\"\nsamples = [320, 322]\num = 300\ntimes = 40\n";
    const auto part_with = [&](const std::string& scan) {
        std::ifstream in("config/parts/demo.toml");
        std::string text(std::istreambuf_iterator<char>(in), {});
        for (const auto& [from, to] : {std::pair<std::string, std::string>{"pitch_mm = 0.4", "pitch_mm = 0.1\n" + scan},
                                       {"count = 8", "count = 2"}})
            text.replace(text.find(from), from.size(), to);
        const std::string file = folder_ / "dense.toml";
        std::ofstream(file) << text;
        return file;
    };
    const std::vector<std::string> lifting{"--faults", folder_ / "lift.toml"};
    const auto lap = measure(part_with(""), "gap", "10", lifting);
    EXPECT_EQ(lap.ended.exit_code, 2) << lap.ended.err;
    ASSERT_FALSE(lap.part.sections.empty());
    EXPECT_EQ(lap.part.sections[0].gaps().size(), 1U);
    const auto again = measure(part_with("until_decided = true"), "filled", "10", lifting);
    EXPECT_EQ(again.ended.exit_code, 0) << again.ended.err;
    ASSERT_FALSE(again.part.sections.empty());
    EXPECT_TRUE(again.part.sections[0].gaps().empty());
    EXPECT_GE(points_of_passes(again.part.sections[0]).at(1), 40U);
    EXPECT_EQ(again.part.verdict(), Decision::accept);
}

}  // namespace
}  // namespace cmm::test
