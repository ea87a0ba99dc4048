// SPDX-License-Identifier: Apache-2.0
// A run file is a machine: what it answers, what it refuses, where it ends. That the demo part gives the same files is
// in transports_test.cpp.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>

#include "core/text.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

constexpr const char* replayed_part = "config/parts/demo.toml";
constexpr const char* unknown_part = "tests/system/parts/unknown.toml";

Finished replay(const std::string& run_file, const std::string& part, const std::string& out,
                const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{cmmlive(), "scan", "--machine", "replay:" + run_file,
                                       "--part",  part,   "--out",     out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
}

void expect_same_files(const std::string& one, const std::string& other, const std::vector<std::string>& names) {
    for (const auto& name : names) {
        const auto left = core::read_file(one + "/" + name);
        const auto right = core::read_file(other + "/" + name);
        ASSERT_TRUE(left) << name;
        ASSERT_TRUE(right) << name;
        EXPECT_FALSE(left->empty()) << name;
        EXPECT_EQ(*left, *right) << name;
    }
}

/// Scans at the given speed and is killed once so many samples were measured.
void broken_scan(SimulatedMachine& machine, const std::string& part, const TemporaryFolder& folder,
                 const std::string& out, std::size_t samples) {
    Process scan(scan_command(machine, part, out, false), folder / "scan");
    ASSERT_TRUE(wait_for([&] { return log_size(machine) > samples * 100; }, std::chrono::seconds(60)));
    scan.signal(SIGKILL);
    scan.wait(std::chrono::seconds(5));
}

TEST(Replay, AnUnknownPartIsMeasuredAgainToTheLastBit) {
    const TemporaryFolder folder;
    SimulatedMachine machine(unknown_part, folder, {"--speed", "0", "--seed", "5"});
    const auto first =
        run({cmmlive(), "scan", "--machine", machine.url(), "--part", unknown_part, "--out", folder / "first"});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    machine.end();
    const auto again = replay(folder / "first/run.cmmrun", unknown_part, folder / "again");
    ASSERT_EQ(again.exit_code, 0) << again.err;
    expect_same_files(
        folder / "first", folder / "again",
        {"sections.csv", "section-0.csv", "section-1.csv", "section-2.csv", "rejected.csv", "points.csv"});
    // The replay's own run file is a machine as well.
    const auto third = replay(folder / "again/run.cmmrun", unknown_part, folder / "third");
    ASSERT_EQ(third.exit_code, 0) << third.err;
    expect_same_files(folder / "first", folder / "third", {"sections.csv", "points.csv"});
}

TEST(Replay, ACommandPlaysARunByThePartFileKeptInIt) {
    const TemporaryFolder folder;
    const std::string part = folder / "blade.toml";
    std::filesystem::copy_file(replayed_part, part);
    ASSERT_EQ(run({cmmlive(), "demo", "--part", part, "--speed", "0", "--out", folder / "first"}).exit_code, 0);
    std::filesystem::remove(part);  // what counts is what the run keeps
    const auto again = run({cmmlive(), "replay", folder / "first", "--speed", "0", "--out", folder / "again"});
    ASSERT_EQ(again.exit_code, 0) << again.err;
    std::vector<std::string> names{"sections.csv", "rejected.csv", "points.csv"};
    for (int section = 0; section < 8; ++section)
        names.push_back("section-" + std::to_string(section) + ".csv");
    expect_same_files(folder / "first", folder / "again", names);

    // Without --out the verdict is told and nothing stays.
    const auto told = run({cmmlive(), "replay", folder / "first/run.cmmrun", "--json", "--events", folder / "events"});
    EXPECT_EQ(told.exit_code, 0) << told.err;
    EXPECT_NE(told.out.find("\"verdict\""), std::string::npos) << told.out;
    EXPECT_NE(core::read_file(folder / "events").value().find("\"RunStopped\""), std::string::npos);
    const auto shown = run({cmmlive(), "replay", folder / "first"});
    EXPECT_EQ(shown.exit_code, 0) << shown.err;
    EXPECT_EQ(shown.out.find("files:"), std::string::npos) << shown.out;
}

TEST(Replay, ACommandThatCannotBeDoneSaysWhy) {
    const TemporaryFolder folder;
    const auto absent = run({cmmlive(), "replay", folder / "none.cmmrun"});
    EXPECT_EQ(absent.exit_code, 6) << absent.err;
    EXPECT_NE(absent.err.find("none.cmmrun"), std::string::npos) << absent.err;
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--out", folder / "run"}).exit_code, 0);
    const auto onto_itself = run({cmmlive(), "replay", folder / "run", "--out", folder / "run"});
    EXPECT_EQ(onto_itself.exit_code, 3) << onto_itself.err;
    EXPECT_NE(onto_itself.err.find("holds a run already"), std::string::npos) << onto_itself.err;
    const auto half = run({cmmlive(), "replay", folder / "run", "--speed", "0.5"});
    EXPECT_EQ(half.exit_code, 3) << half.err;
    EXPECT_NE(half.err.find("whole number"), std::string::npos) << half.err;
}

TEST(Replay, ARunThatWasCutOffLeavesAGapThatIsNotEvaluable) {
    const TemporaryFolder folder;
    SimulatedMachine machine(replayed_part, folder, {"--speed", "30", "--seed", "3"});
    broken_scan(machine, replayed_part, folder, folder / "cut", 1500);
    const auto gap = replay(folder / "cut/run.cmmrun", replayed_part, folder / "gap");
    EXPECT_EQ(gap.exit_code, 2) << gap.err << gap.out;
    EXPECT_NE(gap.err.find("the gap is not evaluable"), std::string::npos) << gap.err;
    const auto sections = read_csv(folder / "gap/sections.csv");
    ASSERT_EQ(sections.size(), 8U);
    EXPECT_EQ(sections.front().at("closed"), "1");
    EXPECT_EQ(sections.back().at("closed"), "0");
    EXPECT_EQ(sections.back().at("profile_le_decision"), "not_evaluable");

    // Finished by --resume it has two paths in one section and plays like any other.
    const auto resumed = Process(scan_command(machine, replayed_part, folder / "cut", true), folder / "resumed")
                             .wait(std::chrono::seconds(60));
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    const auto whole = replay(folder / "cut/run.cmmrun", replayed_part, folder / "whole");
    EXPECT_EQ(whole.exit_code, 0) << whole.err;
    expect_same_files(folder / "cut", folder / "whole",
                      {"sections.csv", "section-0.csv", "section-7.csv", "points.csv"});
}

TEST(Replay, AReplayThatIsKilledGoesOn) {
    const TemporaryFolder folder;
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--out", folder / "first"}).exit_code, 0);
    {
        Process scan({cmmlive(), "scan", "--machine", "replay:" + (folder / "first/run.cmmrun") + "?speed=10", "--part",
                      replayed_part, "--out", folder / "again", "--events", folder / "events"},
                     folder / "scan");
        ASSERT_TRUE(wait_for([&] {
            const auto events = core::read_file(folder / "events");
            return events && events->find("\"SectionFinal\"") != std::string::npos;
        }));
        scan.signal(SIGKILL);
        EXPECT_EQ(scan.wait(std::chrono::seconds(5)).exit_code, 128 + SIGKILL);
    }
    const auto resumed = replay(folder / "first/run.cmmrun", replayed_part, folder / "again", {"--resume"});
    EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
    expect_same_files(folder / "first", folder / "again",
                      {"sections.csv", "section-0.csv", "section-7.csv", "points.csv"});
}

TEST(Replay, WhatItCannotAnswerIsSaid) {
    const TemporaryFolder folder;
    const auto absent = replay(folder / "none.cmmrun", replayed_part, folder / "a");
    EXPECT_EQ(absent.exit_code, 6) << absent.err;
    EXPECT_NE(absent.err.find("none.cmmrun: is not there"), std::string::npos) << absent.err;

    const auto text = replay(replayed_part, replayed_part, folder / "b");
    EXPECT_EQ(text.exit_code, 6) << text.err;
    EXPECT_NE(text.err.find("is not a run file of cmmlive"), std::string::npos) << text.err;

    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--out", folder / "run"}).exit_code, 0);
    const auto file = folder / "run/run.cmmrun";
    const auto other = replay(file, unknown_part, folder / "c");
    EXPECT_EQ(other.exit_code, 3) << other.err;
    EXPECT_NE(other.err.find("made by another plan"), std::string::npos) << other.err;
    const auto planned = run({cmmlive(), "plan", "--machine", "replay:" + file, "--part", unknown_part});
    EXPECT_EQ(planned.exit_code, 3) << planned.err;
    EXPECT_EQ(run({cmmlive(), "plan", "--machine", "replay:" + file, "--part", replayed_part}).exit_code, 0);

    const auto speed = replay(file + "?speed=fast", replayed_part, folder / "d");
    EXPECT_EQ(speed.exit_code, 3);
    EXPECT_NE(speed.err.find("speed must be a whole number"), std::string::npos) << speed.err;
    EXPECT_NE(run({cmmlive(), "doctor"}).out.find("replay"), std::string::npos);
}

}  // namespace
}  // namespace cmm::test
