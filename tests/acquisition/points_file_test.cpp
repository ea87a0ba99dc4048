// SPDX-License-Identifier: Apache-2.0
#include "acquisition/points_file.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"
#include "tests/acquisition/temp_folder.hpp"

namespace cmm::acquisition {
namespace {

class PointsFile : public testing::Test {
  protected:
    std::vector<PointSection> good(const std::string& name, std::string_view content) {
        const auto sections = read_points(folder_.write(name, content));
        EXPECT_TRUE(sections) << sections.error().text();
        return sections.value_or(std::vector<PointSection>{});
    }
    /// The message without the folder in front.
    std::string bad(const std::string& name, std::string_view content) {
        const auto sections = read_points(folder_.write(name, content));
        if (sections) return "";
        EXPECT_EQ(sections.error().code, core::ErrorCode::input_invalid);
        return sections.error().message.substr(folder_.path("").size());
    }
    TempFolder folder_;
};

TEST_F(PointsFile, TellsSectionsApartByTheColumnInOrderOfFirstAppearance) {
    const auto s = good("a.csv",
                        "# made by hand\nX_mm, y ,Z [mm],Section,Flag\n1,2,3,tip,0\n4,5,6,root,1\n1,2,3.5,tip,0\n"
                        "4,5,6,root,0\n1,3,3,tip,0\n4,7,6,root,0\n");
    ASSERT_EQ(s.size(), 2U);
    EXPECT_EQ(s[0].name, "tip");
    EXPECT_EQ(s[1].name, "root");
    EXPECT_TRUE(s[0].flags.empty());
    EXPECT_EQ(s[1].flags, (std::vector<std::uint16_t>{1, 0, 0}));
    EXPECT_EQ(s[0].points_mm[1], Eigen::Vector3d(1, 2, 3.5));
}

TEST_F(PointsFile, TellsSectionsApartByStepsInZ) {
    std::string text = "x,y,z\n";
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 8; ++i)
            text += std::to_string(i) + ",1," + std::to_string(10 * k) + (i % 2 == 0 ? ".000\n" : ".004\n");
    }
    const auto s = good("run.csv", text);
    ASSERT_EQ(s.size(), 3U);
    EXPECT_EQ(s[1].name, "10.000");
    EXPECT_EQ(s[1].points_mm.size(), 8U);
    EXPECT_NEAR(s[2].z_mm(), 20.002, 1e-9);
}

TEST_F(PointsFile, KeepsACurveOfChangingHeightWhole) {
    std::string text = "x y z\n";
    for (int i = 0; i < 20; ++i)
        text += std::to_string(i) + " 1 " + std::to_string(0.1 * i) + "\n";
    const auto s = good("stream.txt", text);
    ASSERT_EQ(s.size(), 1U);
    EXPECT_EQ(s[0].name, "stream");
    EXPECT_EQ(s[0].points_mm.size(), 20U);
}

TEST_F(PointsFile, ReadsSeparatorsLineEndsAndByteOrderMark) {
    const Eigen::Vector3d last(7, 8, 9.5);
    for (const std::string_view text :
         {"\xEF\xBB\xBFx,y,z\r\n1,2,9.5\r\n4,5,9.5\r\n7,8,9.5\r\n", "x;y;z\n1;2;9.5\n4;5;9.5\n7;8;9.5",
          "x\ty\tz\n1\t2\t9.5\n4\t5\t9.5\n7\t8\t9.5\n", "x,y,z\r1,2,9.5\r4,5,9.5\r7,8,9.5\r",
          "\"x\",\"y\",\"z\"\n1,2,9.5,\n4,5,9.5,\n+7,8,0.95e1,\n",
          "//X Y Z\n 1  2 9.5 # first\n\n4 5 9.5\n7 8 9.5\n"}) {
        const auto s = good("f.csv", text);
        ASSERT_EQ(s.size(), 1U) << text;
        ASSERT_EQ(s[0].points_mm.size(), 3U) << text;
        EXPECT_EQ(s[0].points_mm[2], last) << text;
    }
}

TEST_F(PointsFile, TakesTheHeightOfTwoColumnsFromCommentOrName) {
    EXPECT_DOUBLE_EQ(good("p.csv", "# x_mm,y_mm (cut z=300.5 of a mesh)\n1,2\n3,4\n5,7\n")[0].z_mm(), 300.5);
    EXPECT_DOUBLE_EQ(good("p.csv", "# z_mm = -4\nx,y\n1,2\n3,4\n5,7\n")[0].z_mm(), -4.0);
    EXPECT_DOUBLE_EQ(good("section_z345.0.csv", "1,2\n3,4\n5,7\n")[0].z_mm(), 345.0);
    EXPECT_NE(bad("p.csv", "x,y\n1,2\n3,4\n5,6\n").find("no column z"), std::string::npos);
}

TEST_F(PointsFile, ReadsTheContourOfAResult) {
    const auto s =
        good("section-3.csv",
             "x_mm,y_mm,z_mm,nx,ny,nz,zone,deviation_mm,u95_mm\n1,2,5,1,0,0,le,,0.001\n2,2,5,1,0,0,te,0.01,0.001\n"
             "3,2,5,1,0,0,te,0.01,0.001\n");
    ASSERT_EQ(s.size(), 1U);
    EXPECT_EQ(s[0].name, "section-3");
    EXPECT_EQ(s[0].points_mm.size(), 3U);
}

TEST_F(PointsFile, ReadsTurboGridProfiles) {
    const std::string text =
        "# Rotor1 Profile 1\n 1 2 3\n 4 5 6\n 7 8 9\n\n# Rotor1 Profile 2\n1 2 30\n4 5 60\n7 8 90\n";
    for (const std::string name : {"r.crv", "r.curve", "r.dat"}) {
        const auto s = good(name, text);
        ASSERT_EQ(s.size(), 2U) << name;
        EXPECT_EQ(s[1].name, "Rotor1 Profile 2");
        EXPECT_EQ(s[1].points_mm[2], Eigen::Vector3d(7, 8, 90));
    }
    EXPECT_EQ(good("hub.crv", "1 2 3\n4 5 6\n7 8 9\n")[0].name, "hub");
    EXPECT_EQ(bad("b.crv", "# P Profile 1\n1 2 3\n4 5\n"),
              "b.crv:3:1: a point needs three numbers x y z, found 2 fields");
    EXPECT_EQ(bad("b.crv", "# P Profile 1\n1 2 3\n4 5 six\n"), "b.crv:3:5: z is not a number: 'six'");
}

TEST_F(PointsFile, SaysWhatIsWrong) {
    EXPECT_EQ(bad("b.csv", "x,y,z\n1,2,3\n1,abc,3\n1,2,4\n"), "b.csv:3:3: y is not a number: 'abc'");
    EXPECT_EQ(bad("b.csv", "x,y,z\n1,2,NaN\n"), "b.csv:2:5: z is not a finite number: 'NaN'");
    EXPECT_EQ(bad("b.csv", "x,y,z\n-inf,2,3\n"), "b.csv:2:1: x is not a finite number: '-inf'");
    EXPECT_EQ(bad("b.csv", "x,y,z\n1,2,3\n1,2\n"), "b.csv:3:1: 2 fields where the first row has 3");
    EXPECT_EQ(bad("b.csv", "x,z\n1,2\n"), "b.csv: no column y (or y_mm); the columns are: x, z");
    EXPECT_EQ(bad("b.csv", "x_in,y_in,z_in\n1,2,3\n"),
              "b.csv: no column x (or x_mm); the columns are: x_in, y_in, z_in");
    EXPECT_NE(bad("b.csv", "x;y;z\n1,5;2;3\n").find("x is not a number: '1,5'; decimal comma?"), std::string::npos);
    EXPECT_NE(bad("b.csv", "x,y,z\n1,5,2,0,3,0\n").find("decimal commas?"), std::string::npos);
    EXPECT_EQ(bad("b.csv", "x,y,z\n"), "b.csv: no points after the header");
    EXPECT_EQ(bad("b.csv", "x,y,z\n1,2,3\n4,5,3\n"), "b.csv: section 'b' has 2 points; a section needs at least 3");
    EXPECT_EQ(bad("b.csv", ""), "b.csv: the file is empty");
    EXPECT_EQ(bad("b.csv", std::string_view("\x7F"
                                            "ELF\x02\x01\0\0",
                                            8)),
              "b.csv: not a text file (byte 2 at offset 4)");
    EXPECT_NE(bad("b.csv", "\xFF\xFEx").find("UTF-16"), std::string::npos);
    EXPECT_EQ(bad("b.csv", "x,y,z,flag\n1,2,3,-1\n"),
              "b.csv:2:7: flag must be a whole number from 0 to 65535, not '-1'");
    EXPECT_EQ(read_points(folder_.path("absent.csv")).error().code, core::ErrorCode::input_missing);
}

TEST_F(PointsFile, JoinsFilesAndKeepsNamesApart) {
    const std::string one = "# A Profile 1\n1 2 3\n4 5 6\n7 8 9\n";
    const std::vector<std::string> paths{folder_.write("a.crv", one), folder_.write("b.crv", one)};
    const auto s = read_points(paths);
    ASSERT_TRUE(s);
    ASSERT_EQ(s->size(), 2U);
    EXPECT_EQ((*s)[0].name, "A Profile 1");
    EXPECT_EQ((*s)[1].name, "b:A Profile 1");
}

}  // namespace
}  // namespace cmm::acquisition
