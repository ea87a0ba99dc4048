// SPDX-License-Identifier: Apache-2.0
#include "acquisition/part_file.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "acquisition/file_pattern.hpp"
#include "tests/acquisition/temp_folder.hpp"
#include "tests/acquisition/test_blade.hpp"

namespace cmm::acquisition {
namespace {

std::string error_of(const std::string& text) {
    const auto part = parse_part_file(text, "dir/p.toml");
    return part ? "" : part.error().message;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(PartFile, ReadsEveryKeyOfAnUnknownPart) {
    const auto part = parse_part_file(
        replaced(none_part, "box_mm", "start_mm = [-9, 0]\ntoward_mm = [0, 1]\nclearance_mm = 7\nbox_mm") +
            "[stylus]\nradius_mm = 2\nshank_radius_mm = 1.5\nlength_mm = 40\n[gate]\nprofile_mm = "
            "0.1\n[actual]\nanything = 1\n",
        "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->name, "u");
    EXPECT_EQ(part->nominal.kind, NominalKind::none);
    EXPECT_EQ(part->scan.heights_mm, (std::vector<double>{1.0, 2.5}));
    EXPECT_DOUBLE_EQ(part->scan.clearance_mm, 7.0);
    EXPECT_DOUBLE_EQ(part->scan.start_mm->x(), -9.0);
    EXPECT_DOUBLE_EQ(part->scan.toward_mm->y(), 1.0);
    EXPECT_DOUBLE_EQ((*part->scan.box_mm)[3], 5.0);
    EXPECT_DOUBLE_EQ(part->stylus.length_mm, 40.0);
    EXPECT_DOUBLE_EQ(*part->gate.profile_mm, 0.1);
    EXPECT_FALSE(part->gate.edge_profile_mm);
    EXPECT_NE(part->text.find("[actual]"), std::string::npos);
}

TEST(PartFile, ReadsTheSolidOfAStepFile) {
    const std::string step =
        "[part]\nname = \"s\"\n[nominal]\nkind = \"step\"\nfiles = [\"a.step\"]\nsolid = \"AIRFOIL\"\n"
        "[scan]\nheights_mm = [10]\n";
    const auto part = parse_part_file(step, "dir/p.toml");
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->nominal.kind, NominalKind::step);
    EXPECT_EQ(part->nominal.files, std::vector<std::string>{"dir/a.step"});
    EXPECT_EQ(part->nominal.solid, "AIRFOIL");
    EXPECT_NE(error_of(replaced(step, "\"step\"", "\"mesh\"")).find("is for kind = \"step\" only"), std::string::npos);
    EXPECT_NE(error_of(replaced(step, "\"a.step\"", "\"a.step\", \"b.step\"")).find("must name one file"),
              std::string::npos);
}

TEST(PartFile, ReadsTheParametricBladeInRadians) {
    const auto part = parse_part_file("[part]\nname = \"b\"\n[nominal]\nkind = \"parametric\"\n" + blade_table +
                                          "[scan]\nfrom_mm = 10\nto_mm = 50\ncount = 5\n",
                                      "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_NEAR(part->nominal.blade->camber_rad, std::numbers::pi / 6.0, 1e-12);
    EXPECT_NEAR(part->nominal.blade->lean_y_rad, -std::numbers::pi / 60.0, 1e-12);
    EXPECT_EQ(part->scan.heights_mm, (std::vector<double>{10, 20, 30, 40, 50}));
}

TEST(PartFile, ReadsHowSectionsAreFitted) {
    using fitting::EdgeModel;
    using fitting::FilterKind;
    using fitting::Zone;
    const auto plain = parse_part_file(none_part, "p.toml");
    ASSERT_TRUE(plain) << plain.error().text();
    EXPECT_FALSE(plain->fitting.le_model);
    EXPECT_EQ(plain->fitting.fairing_mm, 0.0);
    EXPECT_EQ(plain->fitting.filters.at(Zone::te).kind, FilterKind::none);
    const auto part = parse_part_file(none_part +
                                          "[fitting]\nle_model = \"ellipse\"\nte_model = \"auto\"\nfairing_mm = 0.002\n"
                                          "side_filter = \"gaussian\"\nside_cutoff_mm = 0.8\n"
                                          "edge_filter = \"robust_gaussian\"\nedge_cutoff_mm = 0.08\n",
                                      "p.toml");
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->fitting.le_model, EdgeModel::ellipse);
    EXPECT_FALSE(part->fitting.te_model);
    EXPECT_DOUBLE_EQ(part->fitting.fairing_mm, 0.002);
    for (const Zone side : {Zone::suction, Zone::pressure}) {
        EXPECT_EQ(part->fitting.filters.at(side).kind, FilterKind::gaussian);
        EXPECT_DOUBLE_EQ(part->fitting.filters.at(side).cutoff_mm, 0.8);
    }
    for (const Zone edge : {Zone::le, Zone::te}) {
        EXPECT_EQ(part->fitting.filters.at(edge).kind, FilterKind::robust_gaussian);
        EXPECT_DOUBLE_EQ(part->fitting.filters.at(edge).cutoff_mm, 0.08);
    }
    EXPECT_NE(error_of(none_part + "[fitting]\nle_model = \"square\"\n").find("not \"square\""), std::string::npos);
    EXPECT_NE(error_of(none_part + "[fitting]\ncompensation = \"micro_plan\"\n").find("\"micro_plane\""),
              std::string::npos);
    EXPECT_NE(error_of(none_part + "[fitting]\ncompensation = \"point_distance\"\n").find("needs a nominal"),
              std::string::npos);
    EXPECT_NE(error_of(none_part + "[fitting]\nside_filter = \"spline\"\n").find("side_cutoff_mm is missing"),
              std::string::npos);
    EXPECT_NE(error_of(none_part + "[fitting]\nedge_cutoff_mm = 0.1\n").find("needs edge_filter"), std::string::npos);
}

TEST(PartFile, SaysWhereAndWhatIsWrong) {
    EXPECT_EQ(error_of(replaced(none_part, "heights_mm", "hights_mm")),
              "dir/p.toml:6:1: unknown key scan.hights_mm; did you mean \"heights_mm\"?");
    EXPECT_NE(error_of(replaced(none_part, "box_mm", "box_cm")).find("unknown key scan.box_cm"), std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "[1, 2.5]", "[2.5, 1]")).find("scan.heights_mm must ascend"),
              std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "[1, 2.5]", "[]")).find("at least one height"), std::string::npos);
    EXPECT_NE(error_of(none_part + "count = 3\n").find("exclude each other"), std::string::npos);
    EXPECT_NE(
        error_of(replaced(none_part, "heights_mm = [1, 2.5]", "from_mm = 3\ncount = 2")).find("scan.to_mm is missing"),
        std::string::npos);
    EXPECT_NE(error_of(none_part + "pitch_mm = 0\n").find("scan.pitch_mm must be from 0.002 to 100"),
              std::string::npos);
    EXPECT_NE(error_of(none_part + "[stylus]\nradius_mm = 0\n").find("stylus.radius_mm must be from"),
              std::string::npos);
    EXPECT_NE(error_of(none_part + "[stylus]\nradius_mm = 0.5\nshank_radius_mm = 0.5\n").find("smaller than radius_mm"),
              std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "name = \"u\"\n", "")).find("part.name is missing"), std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "kind = \"none\"", "kind = \"cad\"")).find("not \"cad\""),
              std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "-10, -5, 10, 5", "-10, 5, 10, 5")).find("y0 < y1"), std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "kind = \"none\"", "kind = \"parametric\""))
                  .find("nominal.blade.chord_root_mm is missing"),
              std::string::npos);
    EXPECT_NE(error_of(replaced(none_part, "kind = \"none\"", "kind = \"sections\"")).find("nominal.files must name"),
              std::string::npos);
}

TEST(PartFile, ExpandsPatternsBesideThePartFileInNaturalOrder) {
    const TempFolder folder;
    for (const std::string name : {"section-10.csv", "section-2.csv", "section-1.csv", "note.txt"})
        folder.write("sections/" + name, "x");
    const std::string text =
        "[part]\nname = \"s\"\n[nominal]\nkind = \"sections\"\nfiles = [\"sections/*.csv\", "
        "\"extra.crv\"]\n[scan]\nheights_mm = [1]\n";
    const auto part = load_part_file(folder.write("part.toml", text));
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->nominal.files,
              (std::vector<std::string>{folder.path("sections/section-1.csv"), folder.path("sections/section-2.csv"),
                                        folder.path("sections/section-10.csv"), folder.path("extra.crv")}));
    const auto broken = load_part_file(folder.write("part2.toml", replaced(text, "*.csv", "*.dat")));
    ASSERT_FALSE(broken);
    EXPECT_NE(broken.error().message.find("matches no file"), std::string::npos);
    EXPECT_EQ(load_part_file(folder.path("absent.toml")).error().code, core::ErrorCode::input_missing);
}

TEST(PartFile, WhatIsToBeMeasuredHasTheSectionsThatItsCharacteristicsName) {
    const TempFolder folder;
    const auto error_with = [&](const std::string& characteristic) {
        const auto file = folder.write("p.toml", none_part + "[[characteristic]]\n" + characteristic);
        EXPECT_TRUE(load_part_file(file)) << "points from files have sections of their own";
        const auto part = load_part_to_measure(file);
        return part ? "" : part.error().message;
    };
    EXPECT_EQ(error_with("name = \"chord\"\nsections = [0, 1]\n"), "");
    EXPECT_EQ(error_with("name = \"chord\"\nsections = [0, 2]\n"),
              folder.path("p.toml") +
                  ":10:1: characteristic[0].sections names section 2, but the last one of [scan] is section 1: they "
                  "count from 0");
    EXPECT_NE(error_with("name = \"lean_x\"\ntip_section = 3\n").find("characteristic[0].tip_section names section 3"),
              std::string::npos);
}

TEST(FilePattern, OrdersByTheValueOfDigits) {
    EXPECT_TRUE(natural_less("a2", "a10"));
    EXPECT_FALSE(natural_less("a10", "a2"));
    EXPECT_TRUE(natural_less("a", "a1"));
    EXPECT_TRUE(natural_less("a01", "a1") != natural_less("a1", "a01"));
    EXPECT_FALSE(natural_less("a1", "a1"));
    EXPECT_TRUE(natural_less("x9y", "x09z"));
}

}  // namespace
}  // namespace cmm::acquisition
