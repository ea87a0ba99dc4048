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
    Measured measure(const std::string& part, const std::string& name) {
        const TemporaryFolder of_machine;
        const std::string out = folder_ / name, events = folder_ / (name + "-events");
        SimulatedMachine machine(part, of_machine, {"--speed", "50", "--seed", "14"});
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

}  // namespace
}  // namespace cmm::test
