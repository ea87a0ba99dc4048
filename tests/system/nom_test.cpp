// SPDX-License-Identifier: Apache-2.0
// A user of PC-DMIS Blade brings a nominal file and a tolerance file.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/acquisition/nom_blade.hpp"
#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

using acquisition::nom::Blade;

/// The blade of the nominal file as the simulator builds it from its own formulas; its lean begins at z 0.
const char* const actual = R"([actual]
kind = "parametric"
noise_um = 1
bad_points_percent = 1
[actual.blade]
chord_root_mm = 60
chord_tip_mm = 60
thickness_root_mm = 6
thickness_tip_mm = 6
camber_deg = 28
stagger_root_deg = 30
stagger_tip_deg = 30
le_radius_mm = 0.4
te_radius_mm = 0.25
lean_x_deg = 3
lean_y_deg = -4
z_root_mm = 0
z_tip_mm = 60
)";

nlohmann::json read_result(const std::string& path) {
    std::ifstream file(path);
    return nlohmann::json::parse(file, nullptr, false);
}

class BladeFiles : public testing::Test {
  protected:
    /// `suction_plus_mm`: upper limit of the points of the suction side.
    Finished demo(double suction_plus_mm, const std::string& more) {
        std::ofstream(folder_ / "b.nom") << acquisition::nom::written(
            Blade{}, {.tolerance = [&](const acquisition::synthetic::ContourPoint& point, double) {
                const bool suction = point.zone == fitting::Zone::suction;
                return std::pair(-0.05, suction ? suction_plus_mm : 0.05);
            }});
        std::ofstream(folder_ / "b.tol") << "NUM_SECT 3\nLE_OFFSET 2\nCHORD 0.1 -0.1\nMAXTHK 0.08 -0.08\n"
                                            "LETHCK 0.1 -0.1\nTWIST 0.2 -0.2\nBOWT 0.1 0\nSECTION B-B\nMAXTHK 0.001 "
                                            "-0.001 6.5\n";
        std::ofstream(folder_ / "part.toml")
            << "[part]\nname = \"b\"\n[nominal]\nkind = \"nom\"\nfiles = [\"b.nom\"]\n[tolerance]\nfile = \"b.tol\"\n"
               "[scan]\npitch_mm = 0.6\nmax_speed_mm_s = 40\n"
            << actual << more;
        return run({cmmlive(), "demo", "--part", folder_ / "part.toml", "--speed", "0", "--out", folder_ / "out"});
    }
    nlohmann::json characteristic(std::size_t section, const std::string& name) const {
        const auto result = read_result(folder_ / "out/result.json");
        for (const auto& one : result.at("sections").at(section).at("characteristics"))
            if (one.at("name") == name) return one;
        ADD_FAILURE() << "no " << name;
        return {};
    }

    TemporaryFolder folder_;
};

TEST_F(BladeFiles, AreMeasuredAndJudgedByTheirSectionsPointsAndTolerances) {
    const auto run = demo(0.05, "");
    // By the formula of docs/part-file.md: twice the largest inscribed radius.
    double thickest_mm = 0.0;
    for (double t = 0.0; t < 1.0; t += 1e-5)
        thickest_mm = std::max(thickest_mm, 2.0 * (0.4 * (1.0 - t) + 0.25 * t +
                                                   2.675 * (2.0 * t * (1.0 - t) + 3.375 * t * (1.0 - t) * (1.0 - t))));
    // The file wants section B-B to be 6.5 mm thick, which it is not.
    EXPECT_EQ(run.exit_code, 1) << run.out << run.err;
    for (std::size_t section = 0; section < 3; ++section) {
        const auto points = characteristic(section, "point_tolerance");
        EXPECT_EQ(points.at("decision"), "accept") << points;
        EXPECT_LT(points.at("value").get<double>(), -0.04) << points;
        EXPECT_EQ(characteristic(section, "chord_tangent").at("decision"), "accept");
        EXPECT_EQ(characteristic(section, "le_thickness_2").at("decision"), "accept");
        const auto thickness = characteristic(section, "max_thickness");
        EXPECT_NEAR(thickness.at("value").get<double>(), thickest_mm, 0.003);
        EXPECT_EQ(thickness.at("decision"), section == 1 ? "reject" : "accept") << thickness;
    }
    EXPECT_NEAR(read_result(folder_ / "out/result.json").at("sections").at(2).at("z_mm").get<double>(), 40.0, 1e-9);
}

TEST_F(BladeFiles, ABladeThatIsTooThickIsOutOfThePointsOfOneSideOnly) {
    // 30 um too much on either side: out where 20 um are allowed.
    const auto result = demo(0.02, "");
    EXPECT_EQ(characteristic(0, "point_tolerance").at("decision"), "accept") << result.out;
    std::ifstream in(folder_ / "part.toml");
    std::string text((std::istreambuf_iterator<char>(in)), {});
    text.replace(text.find("noise_um"), 8, "thicken_mm = 0.06\nnoise_um");
    std::ofstream(folder_ / "part.toml") << text;
    const auto out =
        run({cmmlive(), "demo", "--part", folder_ / "part.toml", "--speed", "0", "--out", folder_ / "thick"});
    EXPECT_EQ(out.exit_code, 1) << out.out << out.err;
    const auto json = read_result(folder_ / "thick/result.json");
    for (const auto& section : json.at("sections"))
        for (const auto& one : section.at("characteristics")) {
            if (one.at("name") != "point_tolerance") continue;
            EXPECT_EQ(one.at("decision"), "reject") << one;
            EXPECT_NEAR(one.at("value").get<double>(), 0.01, 0.004) << one;
        }
}

TEST_F(BladeFiles, WhatIsWrongInThemIsSaidWithItsPlace) {
    demo(0.05, "");
    std::ofstream(folder_ / "b.tol") << "CHORD 0.1 -0.1\nLERAD 0.1 -0.1\n";
    const auto refused = run({cmmlive(), "plan", "--part", folder_ / "part.toml"});
    EXPECT_EQ(refused.exit_code, 3) << refused.out << refused.err;
    EXPECT_NE(refused.err.find("b.tol:2:1: LERAD is not evaluated"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace cmm::test
