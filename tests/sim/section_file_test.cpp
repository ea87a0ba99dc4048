// SPDX-License-Identifier: Apache-2.0
#include "sim/section_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/text.hpp"

namespace cmm::sim {
namespace {

/// Rows of a regular polygon, written by `row(x, y)`.
template <class Row>
std::string polygon(int n, const Row& row, bool closed = false) {
    std::string text;
    for (int i = 0; i < n + (closed ? 1 : 0); ++i) {
        const double a = 2.0 * std::numbers::pi * (i % n) / n;
        text += row(core::fixed(10.0 * std::cos(a), 6), core::fixed(5.0 * std::sin(a), 6));
    }
    return text;
}

std::vector<Points> read(const std::string& text, const std::string& name) {
    auto profiles = parse_sections(text, name);
    EXPECT_TRUE(profiles) << profiles.error().text();
    return profiles.value_or(std::vector<Points>{});
}

std::string message(const std::string& text, const std::string& name) {
    const auto profiles = parse_sections(text, name);
    return profiles ? "read" : profiles.error().message;
}

TEST(SectionFile, CsvWithSectionAndFlagColumns) {
    std::string text = "# two sections\nx,y,z,section,flag\n";
    text += polygon(
        9, [](auto x, auto y) { return x + "," + y + ",3,a,0\n"; }, true);
    text += "99,99,3,a,1\n";
    text += polygon(12, [](auto x, auto y) { return x + "," + y + ",5,b,\n"; });
    const auto profiles = read(text, "s.csv");
    ASSERT_EQ(profiles.size(), 2U);
    EXPECT_EQ(profiles[0].size(), 9U);
    EXPECT_EQ(profiles[1].size(), 12U);
    EXPECT_EQ(profiles[1][0], Eigen::Vector3d(10.0, 0.0, 5.0));
}

TEST(SectionFile, ColumnsByNameAnyOrder) {
    const auto profiles = read(
        "nx;z_mm;y_mm;x_mm\r\n" + polygon(8, [](auto x, auto y) { return "7;4.5;" + y + ";" + x + "\r\n"; }), "s.csv");
    ASSERT_EQ(profiles.size(), 1U);
    EXPECT_EQ(profiles[0][0], Eigen::Vector3d(10.0, 0.0, 4.5));
}

TEST(SectionFile, PlanesOfOneFileAreTakenApart) {
    std::string text;
    for (const char* z : {"1", "2.5", "4"})
        text += polygon(
            10, [&](auto x, auto y) { return "  " + x + "\t " + y + "   " + z + "\n"; }, true);
    for (const char* name : {"s.xyz", "s.asc", "s.txt"}) {
        const auto profiles = read(text, name);
        ASSERT_EQ(profiles.size(), 3U);
        EXPECT_EQ(profiles[1].size(), 10U);
        EXPECT_EQ(profiles[1][0].z(), 2.5);
    }
}

TEST(SectionFile, TwoColumnsTakeTheirHeightFromCommentOrName) {
    const std::string rows = polygon(8, [](auto x, auto y) { return x + "," + y + "\n"; });
    EXPECT_EQ(read("# cut at z=12.5 of it\n" + rows, "s.csv")[0][3].z(), 12.5);
    EXPECT_EQ(read(rows, "dir_z9/section_z300.25.csv")[0][3].z(), 300.25);
    EXPECT_EQ(message(rows, "s.csv"),
              "s.csv:1:1: two columns and no height: put z=<number> in a comment or _z<number> in the file name");
}

TEST(SectionFile, TurboGridProfiles) {
    std::string text;
    for (int k = 1; k <= 3; ++k) {
        text += "# blade Profile " + std::to_string(k) + "\r\n" +
                polygon(
                    8 + k, [&](auto x, auto y) { return " " + x + "  " + y + " " + std::to_string(k) + "\r\n"; }, true);
    }
    for (const char* name : {"b.crv", "B.CURVE"}) {
        const auto profiles = read(text, name);
        ASSERT_EQ(profiles.size(), 3U);
        EXPECT_EQ(profiles[0].size(), 9U);
        EXPECT_EQ(profiles[2].size(), 11U);
    }
}

TEST(SectionFile, ErrorsSayLineAndColumn) {
    EXPECT_EQ(message("x,y,z\n1,2,3\n1, abc,3\n", "s.csv"), "s.csv:3:4: y is not a number: 'abc'");
    EXPECT_EQ(message("1,2,3\n1,nan,3\n", "s.csv"), "s.csv:2:3: y is not a number: 'nan'");
    EXPECT_EQ(message("1 2 3\n4 5\n", "s.xyz"), "s.xyz:2:3: 2 columns where 3 are needed");
    EXPECT_EQ(message("x_inch,y_inch,z_inch\n1,2,3\n", "s.csv"),
              "s.csv:1:1: column 'x_inch': coordinates are in millimetres (x_mm, y_mm, z_mm)");
    EXPECT_EQ(message("a,b,c\n1,2,3\n", "s.csv"), "s.csv:1:1: the header names no columns x and y");
    EXPECT_EQ(message("1,2,3\n4,5,3\n", "s.csv"), "s.csv: profile 1 has 2 points; it needs at least 8");
    EXPECT_EQ(message("# nothing\n", "s.csv"), "s.csv: no points in it");
    EXPECT_EQ(message("1,2,3,a,z\n", "s.csv"), "s.csv:1:9: flag is not a number: 'z'");
}

TEST(SectionFile, SpanIsTurnedToZ) {
    const auto folder = std::filesystem::temp_directory_path() / "cmm_section_file_test";
    std::filesystem::create_directories(folder);
    const std::string file = (folder / "s.csv").string();
    std::string text = "x,y,z,section\n";
    for (int k = 0; k < 2; ++k) {
        text += polygon(8, [&](auto a, auto b) {
            return b + "," + std::to_string(20 + 30 * k) + "," + a + "," + std::to_string(k) + "\n";
        });
    }
    ASSERT_TRUE(core::write_file(file, text));
    // (x, y, z) -> (z, x, y) for span y
    for (const char* span : {"auto", "y"}) {
        const auto profiles = read_sections({file}, span);
        ASSERT_TRUE(profiles);
        EXPECT_EQ((*profiles)[1][0], Eigen::Vector3d(10.0, 0.0, 50.0));
    }
    EXPECT_EQ((*read_sections({file}, "x"))[1][0], Eigen::Vector3d(50.0, 10.0, 0.0));
    EXPECT_EQ((*read_sections({file}, "z"))[1][0], Eigen::Vector3d(0.0, 50.0, 10.0));
    EXPECT_EQ(read_sections({(folder / "none.csv").string()}, "auto").error().code, core::ErrorCode::input_missing);
    std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace cmm::sim
