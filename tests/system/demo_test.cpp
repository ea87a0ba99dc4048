// SPDX-License-Identifier: Apache-2.0
// The main job as a user runs it: one command, a verdict, the files of the contract.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

constexpr std::size_t demo_sections = 8;

void expect_contract_files(const TemporaryFolder& folder) {
    for (const char* name :
         {"run.cmmrun", "sections.csv", "rejected.csv", "result.json", "report.html", "points.csv"}) {
        EXPECT_TRUE(std::filesystem::exists(folder / name)) << name;
    }
    const auto sections = read_csv(folder / "sections.csv");
    ASSERT_EQ(sections.size(), demo_sections);
    for (std::size_t i = 0; i < sections.size(); ++i) {
        EXPECT_EQ(sections[i].at("index"), std::to_string(i));
        EXPECT_EQ(sections[i].at("closed"), "1");
        EXPECT_FALSE(sections[i].at("profile_le_decision").empty());
        const auto contour = read_contour(folder / ("section-" + std::to_string(i) + ".csv"));
        ASSERT_GE(contour.size(), 2000U);
        std::set<std::string> zones;
        std::vector<Eigen::Vector2d> polyline;
        for (const auto& row : contour) {
            zones.insert(row.zone);
            polyline.emplace_back(row.position_mm.head<2>());
            EXPECT_NEAR(row.normal.norm(), 1.0, 1e-5);
            EXPECT_GT(row.u95_mm, 0.0);
        }
        EXPECT_EQ(zones, (std::set<std::string>{"le", "pressure", "suction", "te"}));
        EXPECT_GT(signed_area(polyline), 0.0) << "not counter-clockwise";
    }
}

TEST(Demo, TheGoodBladeIsAcceptedAndEveryFileIsThere) {
    const TemporaryFolder folder;
    const auto demo = run({cmmlive(), "demo", "--speed", "0", "--out", folder.path()});
    EXPECT_EQ(demo.exit_code, 0) << demo.out << demo.err;
    EXPECT_NE(demo.out.find("accept"), std::string::npos) << demo.out;
    expect_contract_files(folder);
}

TEST(Demo, TheBadBladeIsRejectedAndTheReasonsAreNamed) {
    const TemporaryFolder folder;
    const auto demo =
        run({cmmlive(), "demo", "--part", "config/parts/demo-bad.toml", "--speed", "0", "--out", folder.path()});
    EXPECT_EQ(demo.exit_code, 1) << demo.out << demo.err;
    EXPECT_NE(demo.out.find("reject"), std::string::npos) << demo.out;
    EXPECT_NE(demo.out.find("profile_"), std::string::npos) << demo.out;
    expect_contract_files(folder);
}

TEST(Demo, SectionsGrowWhilePointsStillArrive) {
    const TemporaryFolder folder;
    const auto demo = run(
        {cmmlive(), "demo", "--speed", "20", "--out", folder.path(), "--events", folder / "events.ndjson", "--json"});
    ASSERT_EQ(demo.exit_code, 0) << demo.err;
    EXPECT_EQ(nlohmann::json::parse(demo.out).at("verdict"), "accept");

    std::uint64_t expected_seq = 1;
    std::map<int, int> updates_before_last_point;
    std::map<int, int> batches;
    std::map<int, bool> final_seen;
    std::map<int, int> pending;  // updates since the last batch: they count once another batch follows
    for (const auto& event : read_ndjson(folder / "events.ndjson")) {
        EXPECT_EQ(event.at("seq").get<std::uint64_t>(), expected_seq++);
        EXPECT_TRUE(event.contains("t_machine_s") && event.contains("t_host_s"));
        const std::string kind = event.at("event");
        const int section = event.value("section", -1);
        if (kind == "SampleBatch") {
            EXPECT_FALSE(final_seen[section]) << "a point after the section's end";
            ++batches[section];
            updates_before_last_point[section] += std::exchange(pending[section], 0);
        } else if (kind == "SectionUpdated") {
            ++pending[section];
        } else if (kind == "SectionFinal") {
            final_seen[section] = true;
        }
    }
    EXPECT_EQ(final_seen.size(), demo_sections);
    for (const auto& [section, count] : batches) {
        EXPECT_GT(count, 3) << section;
        EXPECT_GE(updates_before_last_point[section], 3) << section;
    }
}

TEST(Demo, TheSameSeedGivesTheSameFilesToTheLastByte) {
    const TemporaryFolder first;
    const TemporaryFolder second;
    const TemporaryFolder other;
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--seed", "5", "--out", first.path()}).exit_code, 0);
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "50", "--seed", "5", "--out", second.path()}).exit_code, 0);
    ASSERT_EQ(run({cmmlive(), "demo", "--speed", "0", "--seed", "6", "--out", other.path()}).exit_code, 0);
    const auto text = [](const std::string& path) {
        std::ifstream in(path);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    for (const char* name : {"sections.csv", "section-0.csv", "section-7.csv", "rejected.csv", "points.csv"}) {
        EXPECT_EQ(text(first / name), text(second / name)) << name;
        EXPECT_NE(text(first / name), text(other / name)) << name;
    }
}

}  // namespace
}  // namespace cmm::test
