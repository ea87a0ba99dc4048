// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/text.hpp"
#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

/// Two repeats of one part as two operators measure it.
TEST(Study, OfRunsOnTheSimulatedMachine) {
    const TemporaryFolder folder;
    std::string design = "run,part,appraiser\n";
    std::vector<std::string> runs;
    for (const char* seed : {"1", "2", "3", "4"}) {
        const auto out = folder / (std::string("run-") + seed);
        ASSERT_EQ(run({cmmlive(), "demo", "--out", out, "--seed", seed, "--speed", "0"}).exit_code, 0);
        design += std::string("run-") + seed + ",," + (seed[0] < '3' ? "Li" : "Mei") + "\n";
        runs.push_back(out);
    }
    ASSERT_TRUE(core::write_file(folder / "design.csv", design));

    const auto alone = run({cmmlive(), "study", runs[0], runs[1], runs[2], runs[3]});
    EXPECT_EQ(alone.exit_code, 0) << alone.err;
    EXPECT_NE(alone.out.find("1 part, 1 appraiser (cmmlive sim"), std::string::npos) << alone.out;
    EXPECT_NE(alone.out.find("One appraiser: GRR is the repeatability alone"), std::string::npos);

    const auto html = folder / "study.html";
    const auto two = run(
        {cmmlive(), "study", runs[0], "--design", folder / "design.csv", "--format", "html", "--out", html, "--json"});
    ASSERT_EQ(two.exit_code, 0) << two.err;
    const auto document = nlohmann::json::parse(two.out);
    EXPECT_EQ(document.at("runs"), 4) << "a run that stands in both counts once";
    EXPECT_EQ(document.at("parts"), nlohmann::json({"D-0001"})) << "as the run says";
    EXPECT_EQ(document.at("appraisers"), nlohmann::json({"Li", "Mei"}));
    bool chord = false;
    for (const auto& one : document.at("characteristics")) {
        if (one.at("name") != "chord z 15.000") continue;
        chord = true;
        EXPECT_EQ(one.at("trials"), 2);
        const double standard = one.at("components").at("repeatability").at("standard");
        EXPECT_GT(standard, 0.0);
        EXPECT_LT(standard, 0.01) << "noise of 1 um does not move a chord by 10 um";
        EXPECT_FALSE(one.at("components").at("reproducibility").is_null());
        EXPECT_TRUE(one.at("components").at("part_variation").is_null());
    }
    EXPECT_TRUE(chord);
    EXPECT_NE(core::read_file(html).value().find("<svg"), std::string::npos);

    const auto once = run({cmmlive(), "study", runs[0]});
    EXPECT_EQ(once.exit_code, 3);
    EXPECT_NE(once.err.find("part D-0001 was measured 1 time by"), std::string::npos) << once.err;
    ASSERT_TRUE(core::write_file(folder / "no.csv", "run,who\nrun-1,Li\n"));
    const auto wrong = run({cmmlive(), "study", "--design", folder / "no.csv"});
    EXPECT_EQ(wrong.exit_code, 3);
    EXPECT_NE(wrong.err.find("no column \"part\""), std::string::npos) << wrong.err;
    EXPECT_EQ(run({cmmlive(), "study", runs[0], "--format", "csv"}).exit_code, 3) << "no file to write";
}

}  // namespace
}  // namespace cmm::test
