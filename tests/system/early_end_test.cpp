// SPDX-License-Identifier: Apache-2.0
// A blade that is out of tolerance: the run ends as soon as that is certain, and may be gone on with.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

/// With more points in a section than the machine gets ahead of the probe.
std::string bad_part(const TemporaryFolder& folder) {
    std::ifstream in("config/parts/demo-bad.toml");
    const std::string file = folder / "part.toml";
    std::ofstream out(file);
    for (std::string line; std::getline(in, line);)
        out << (line.starts_with("pitch_mm") ? "pitch_mm = 0.1" : line) << '\n';
    return file;
}

TEST(EarlyEnd, ARejectedBladeIsMeasuredNoFurtherThanNeededAndToTheEndOnRequest) {
    const TemporaryFolder folder;
    const std::string out = folder / "out", part = bad_part(folder);
    SimulatedMachine machine(part, folder, {"--speed", "20"});
    ASSERT_FALSE(machine.url().empty()) << machine.process().err();
    auto command = scan_command(machine, part, out, false);
    command.insert(command.end(), {"--stop-when-rejected", "--events", folder / "events"});
    const auto ended = run(command);
    EXPECT_EQ(ended.exit_code, 1) << ended.out << ended.err;
    EXPECT_NE(ended.out.find("profile_"), std::string::npos) << ended.out;
    const auto first = read_csv(out + "/sections.csv");
    ASSERT_EQ(first.size(), 1U);
    EXPECT_EQ(first[0].at("closed"), "0");
    EXPECT_EQ(state_of(machine).state, "idle");
    bool told = false;
    for (const auto& event : read_ndjson(folder / "events")) {
        if (event.at("event") != "GateDecision" || !event.contains("while_measuring")) continue;
        told = true;
        EXPECT_EQ(event.at("decision"), "reject");
        EXPECT_GT(std::abs(event.at("deviation_mm").get<double>()) - event.at("guard_mm").get<double>(),
                  0.5 * event.at("limit_mm").get<double>());
    }
    EXPECT_TRUE(told);

    const auto resumed = run(scan_command(machine, part, out, true));
    EXPECT_EQ(resumed.exit_code, 1) << resumed.out << resumed.err;
    const auto sections = read_csv(out + "/sections.csv");
    EXPECT_EQ(sections.size(), 8U);
    for (const auto& section : sections)
        EXPECT_EQ(section.at("closed"), "1");
    machine.end();
    expect_every_sample_once(out + "/run.cmmrun", machine.log());
}

}  // namespace
}  // namespace cmm::test
