// SPDX-License-Identifier: Apache-2.0
// What a user gets wrong: each case ends with the contract's exit code, says what and where, and what to do.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

struct BadCase {
    const char* name;
    const char* file;
    const char* content;
    const char* expected;
};

class BadPoints : public testing::TestWithParam<BadCase> {};

TEST_P(BadPoints, FitSaysWhatAndWhere) {
    const TemporaryFolder folder;
    const std::string file = folder / GetParam().file;
    std::ofstream(file) << GetParam().content;
    const auto fit = run({cmmlive(), "fit", file, "--stylus-radius", "1", "--out", folder / "out"});
    EXPECT_EQ(fit.exit_code, 3) << fit.out << fit.err;
    EXPECT_NE(fit.err.find(GetParam().expected), std::string::npos) << fit.err;
    EXPECT_NE(fit.err.find("\n  "), std::string::npos) << "no advice: " << fit.err;
}

INSTANTIATE_TEST_SUITE_P(Files, BadPoints,
                         testing::Values(BadCase{"MissingColumn", "p.csv", "x,y\n1,2\n3,4\n5,6\n",
                                                 "p.csv: no column z"},
                                         BadCase{"NotANumber", "p.csv", "x,y,z\n0,0,0\n1,abc,0\n2,0,0\n", "p.csv:3:3"},
                                         BadCase{"Nan", "p.csv", "x,y,z\n0,0,0\n1,0,0\nnan,0,0\n", "p.csv:4:1"},
                                         BadCase{"TwoPoints", "p.csv", "x,y,z\n0,0,0\n1,0,0\n", "p.csv"},
                                         BadCase{"Empty", "p.csv", "", "p.csv"}),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(BadInput, AnOpenScanIsShownAsOpenAndNotEvaluable) {
    const TemporaryFolder folder;
    const std::string file = folder / "open.csv";
    {
        std::ofstream out(file);
        out << "x,y,z\n";
        for (int i = 0; i < 300; ++i)
            out << 20.0 * std::cos(0.01 * i) << "," << 5.0 * std::sin(0.01 * i) << ",10\n";
    }
    const auto fit = run({cmmlive(), "fit", file, "--stylus-radius", "1", "--out", folder / "out"});
    EXPECT_EQ(fit.exit_code, 2) << fit.out << fit.err;
    EXPECT_NE(fit.out.find("open"), std::string::npos) << fit.out;
}

TEST(BadInput, AWrongUnitsKeyIsNamedWithASuggestion) {
    const TemporaryFolder folder;
    const std::string file = folder / "part.toml";
    std::ofstream(file) << "[part]\nname = \"p\"\nkind = \"blade\"\n[nominal]\nkind = \"none\"\n[scan]\npitch_um = "
                           "400\nheights_mm = [1]\n";
    const auto plan = run({cmmlive(), "plan", "--part", file});
    EXPECT_EQ(plan.exit_code, 3);
    EXPECT_NE(plan.err.find("part.toml:7:1: unknown key scan.pitch_um; did you mean \"pitch_mm\"?"), std::string::npos)
        << plan.err;
}

TEST(BadInput, ASectionWithoutAHeightIsNamedBeforeAnythingMoves) {
    const TemporaryFolder folder;
    const std::string file = folder / "part.toml";
    std::ifstream demo("config/parts/demo.toml");
    std::ofstream(file) << demo.rdbuf() << "\n[[characteristic]]\nname = \"chord\"\nsections = [8]\n";
    for (const std::vector<std::string>& command : {std::vector<std::string>{"config", "check", file},
                                                    {"plan", "--part", file},
                                                    {"demo", "--part", file, "--out", folder / "out"}}) {
        std::vector<std::string> words{cmmlive()};
        words.insert(words.end(), command.begin(), command.end());
        const auto told = run(words);
        EXPECT_EQ(told.exit_code, 3) << command.front();
        EXPECT_NE(told.err.find("sections names section 8, but the last one of [scan] is section 7"), std::string::npos)
            << told.err;
    }
}

TEST(BadInput, AnUnreachableMachineIsALinkError) {
    const TemporaryFolder folder;
    const auto scan = run({cmmlive(), "scan", "--machine", "modbus+tcp://127.0.0.1:9", "--part",
                           "config/parts/demo.toml", "--out", folder / "out"});
    EXPECT_EQ(scan.exit_code, 5) << scan.err;
    EXPECT_NE(scan.err.find("127.0.0.1"), std::string::npos) << scan.err;
}

TEST(BadInput, AnUnwritableFolderIsAStorageError) {
    const auto demo = run({cmmlive(), "demo", "--speed", "0", "--out", "/proc/nowhere"});
    EXPECT_EQ(demo.exit_code, 6) << demo.err;
}

TEST(BadInput, AFullDiskStopsTheMachineAndTheRunCanGoOn) {
    const TemporaryFolder folder;
    const std::string disk = folder / "disk";
    const auto mounted = run({"sh", "-c", "mkdir " + disk + " && mount -t tmpfs -o size=300k tmpfs " + disk});
    if (mounted.exit_code != 0) GTEST_SKIP() << "no right to mount a small disk: " << mounted.err;
    const auto demo = run({cmmlive(), "demo", "--speed", "0", "--wait-s", "0", "--out", disk});
    run({"umount", disk});
    EXPECT_EQ(demo.exit_code, 6) << demo.out << demo.err;
    EXPECT_NE(demo.err.find("Free space"), std::string::npos) << demo.err;
}

TEST(BadInput, JsonMayStandBeforeTheCommandToo) {
    const auto before = run({cmmlive(), "--json", "config", "check", "config/parts/demo.toml"});
    const auto after = run({cmmlive(), "config", "check", "config/parts/demo.toml", "--json"});
    EXPECT_EQ(before.exit_code, 0) << before.err;
    EXPECT_EQ(before.out, after.out);
    EXPECT_EQ(after.out.front(), '{');
}

TEST(BadInput, UsageErrorsAreThree) {
    for (const std::vector<std::string>& arguments : {std::vector<std::string>{},
                                                      {"nonsense"},
                                                      {"scan"},
                                                      {"fit", "--out", "x"},
                                                      {"demo", "--speed", "-1"},
                                                      {"config", "check"}}) {
        std::vector<std::string> command{cmmlive()};
        command.insert(command.end(), arguments.begin(), arguments.end());
        EXPECT_EQ(run(command).exit_code, 3) << (arguments.empty() ? "(none)" : arguments.front());
        command.push_back("--json");
        const auto told = run(command);
        EXPECT_EQ(told.exit_code, 3) << told.err;
        const auto document = nlohmann::json::parse(told.out, nullptr, false);
        ASSERT_TRUE(document.is_object()) << told.out << told.err;
        EXPECT_EQ(document["error"]["code"], "usage");
        EXPECT_EQ(document["exit_code"], 3);
        EXPECT_NE(told.err.find("--help"), std::string::npos) << told.err;
    }
    EXPECT_EQ(run({cmmlive(), "--json"}).exit_code, 3);
    EXPECT_EQ(run({cmmlive(), "--version"}).exit_code, 0);
    EXPECT_EQ(run({cmmlive(), "doctor"}).exit_code, 0);
    EXPECT_EQ(run({cmmlive(), "config", "check", "config/parts/demo.toml"}).exit_code, 0);
    EXPECT_EQ(run({cmmlive(), "config", "explain"}).exit_code, 0);
}

}  // namespace
}  // namespace cmm::test
