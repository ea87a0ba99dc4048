// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <numbers>

#include "core/text.hpp"
#include "sim/section_cut.hpp"
#include "sim/surface.hpp"

namespace cmm::sim {
namespace {

const std::string blade_keys =
    "chord_root_mm = 40.0\nchord_tip_mm = 34.0\nthickness_root_mm = 4.0\nthickness_tip_mm = 2.8\ncamber_deg = 30.0\n"
    "stagger_root_deg = 20.0\nstagger_tip_deg = 32.0\nle_radius_mm = 0.6\nte_radius_mm = 0.4\nlean_x_deg = 1.0\n"
    "lean_y_deg = -2.0\nz_root_mm = 0.0\nz_tip_mm = 50.0\n";
const std::string parametric = "[part]\nname = \"b\"\n[nominal]\nkind = \"parametric\"\n[nominal.blade]\n" + blade_keys;

class PartFile : public ::testing::Test {
  protected:
    void SetUp() override {
        const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
        folder_ = std::filesystem::temp_directory_path() / (std::string("cmm_part_") + test->name());
        std::filesystem::create_directories(folder_);
    }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void write(const std::string& name, const std::string& text) {
        ASSERT_TRUE(core::write_file((folder_ / name).string(), text));
    }
    core::Result<Part> load(const std::string& text) {
        write("part.toml", text);
        return load_part((folder_ / "part.toml").string());
    }
    std::string message(const std::string& text) {
        const auto part = load(text);
        if (part) return "loaded";
        const std::string all = part.error().message;
        const auto at = all.find("part.toml");
        return at == std::string::npos ? all : all.substr(at);
    }
    static Eigen::Vector2d centre(const Part& part, double z) {
        const Contour contour = cut_section(*part.surface, z).value().front();
        Eigen::Vector2d low = contour[0], high = contour[0];
        for (const auto& p : contour) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
        return 0.5 * (low + high);
    }

    std::filesystem::path folder_;
};

TEST_F(PartFile, EveryKeyOfTheDocumentIsKnown) {
    const auto part = load(
        "[part]\nname = \"rotor\"\nkind = \"blade\"\nserial = \"7\"\n[nominal]\nkind = \"parametric\"\nspan = "
        "\"z\"\nle_hint_mm = [1, 2]\n"
        "[nominal.blade]\n" +
        blade_keys +
        "[stylus]\nradius_mm = 1.5\nshank_radius_mm = 0.6\nlength_mm = 20.0\n[scan]\nheights_mm = [1]\nanything = "
        "1\n[alignment]\nkind = \"blade\"\n[gate]\n"
        "profile_mm = 0.1\n[actual]\nkind = \"nominal\"\nfiles = []\nspan = \"auto\"\nnoise_um = "
        "2.0\nbad_points_percent = 3.0\n"
        "thicken_mm = 0.1\ntwist_deg = 0.5\nshift_mm = [0.1, 0.2]\nball_error_um = 0.5\nlobes_um = 1.0\nlobes = "
        "3\nlobes_from_deg = 30\nscale_um_m = [1, 2, 3]\nsquareness_um_m = [4, 5, 6]\ngrowth_um_m = 23\n"
        "[uncertainty]\nanything = 1\n");
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_EQ(part->name, "rotor");
    EXPECT_NEAR(part->ball_radius_mm, 1.5005, 1e-12);
    EXPECT_NEAR(part->error.lobes_mm, 0.001, 1e-15);
    EXPECT_NEAR(part->error.scale.z(), 3e-6, 1e-18);
    EXPECT_NEAR(part->error.squareness.x(), 4e-6, 1e-18);
    EXPECT_NEAR(part->noise_mm, 0.002, 1e-15);
    EXPECT_NEAR(part->bad_points_share, 0.03, 1e-15);
}

TEST_F(PartFile, ErrorsSayWhereAndWhat) {
    EXPECT_EQ(message("[part]\nnam = \"b\"\n"), "part.toml:2:1: unknown key part.nam; did you mean \"name\"?");
    EXPECT_NE(message(parametric + "[actual]\nnoise = 1.0\n").find("unknown key actual.noise"), std::string::npos);
    EXPECT_NE(message(parametric + "[gates]\nx = 1\n").find("unknown key gates"), std::string::npos);
    EXPECT_NE(message(parametric + "[stylus]\nradius_mm = 0\n").find("stylus.radius_mm must be above 0"),
              std::string::npos);
    EXPECT_NE(message(parametric + "[stylus]\nradius_mm = 1\nshank_radius_mm = 1\n").find("below radius_mm"),
              std::string::npos);
    EXPECT_NE(message(parametric + "[actual]\nshift_mm = [1]\n").find("shift_mm must be [x, y]"), std::string::npos);
    EXPECT_NE(message("[part]\nname=\"b\"\n[nominal]\nkind=\"none\"\n").find("nothing to simulate"), std::string::npos);
    EXPECT_NE(message("[part]\nname=\"b\"\n[nominal]\nkind=\"step\"\nfiles=[\"a.step\"]\nsolid=\"1\"\n")
                  .find("which the simulator does not read"),
              std::string::npos);
    EXPECT_NE(message("[part]\nname=\"b\"\n[nominal]\nkind=\"mesh\"\nfiles=[]\n").find("must name at least one file"),
              std::string::npos);
    EXPECT_NE(
        message("[part]\nname=\"b\"\n[nominal]\nkind=\"mesh\"\nfiles=[\"a.ply\",\"b.ply\"]\n").find("one .ply or .stl"),
        std::string::npos);
    EXPECT_NE(message("[part]\nname=\"b\"\n[nominal]\nkind=\"parametric\"\n").find("chord_root_mm is missing"),
              std::string::npos);
    EXPECT_NE(
        message("[part]\nname=\"b\"\n[nominal]\nkind=\"mesh\"\nfiles=[\"no.ply\"]\n").find("no.ply: cannot be read"),
        std::string::npos);
    EXPECT_NE(message("[part]\nname=\"b\"\n[nominal]\nkind=\"sections\"\nfiles=[\"no*.csv\"]\n")
                  .find("no*.csv: no file of that name"),
              std::string::npos);
    std::string flat = parametric;
    flat.replace(flat.find("z_tip_mm = 50.0"), 15, "z_tip_mm = -5.0");
    EXPECT_EQ(message(flat), "part.toml:4:1: blade: z_tip_mm must be above z_root_mm");
    EXPECT_EQ(load_part("no/part.toml").error().code, core::ErrorCode::input_missing);
}

TEST_F(PartFile, NominalNoneTakesTheActualGeometry) {
    const auto part = load(
        "[part]\nname=\"b\"\n[nominal]\nkind=\"none\"\n[actual]\nkind=\"parametric\"\n[actual.blade]\n" + blade_keys);
    ASSERT_TRUE(part) << part.error().text();
    EXPECT_TRUE(cut_section(*part->surface, 25.0));
}

TEST_F(PartFile, ThickeningMovesEachSideByHalf) {
    const auto plain = load(parametric).value(), thick = load(parametric + "[actual]\nthicken_mm = 0.2\n").value();
    std::size_t warm = 0;
    for (const Eigen::Vector3d& p :
         {Eigen::Vector3d(0, 10, 20), Eigen::Vector3d(0, -10, 30), Eigen::Vector3d(40, 0, 25)}) {
        EXPECT_NEAR(plain.surface->nearest(p, warm).distance_mm - thick.surface->nearest(p, warm).distance_mm, 0.1,
                    1e-9);
    }
}

TEST_F(PartFile, ShiftMovesAndTwistTurnsTheTopAboutTheMiddle) {
    const auto plain = load(parametric).value();
    const auto moved = load(parametric + "[actual]\nshift_mm = [0.3, -0.2, 0.0]\n").value();
    EXPECT_LT((centre(moved, 25.0) - centre(plain, 25.0) - Eigen::Vector2d(0.3, -0.2)).norm(), 1e-6);

    const double twist = 2.0 * std::numbers::pi / 180.0;
    const auto turned = load(parametric + "[actual]\ntwist_deg = 2.0\n").value();
    // The axis: the middle of the part's box between root and tip. The plain surface reaches a ball radius farther.
    Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
    for (double z = 0.0; z <= 50.0; z += 0.5) {
        const Contour contour = cut_section(*plain.surface, z).value().front();
        for (const auto& p : contour) {
            low = low.cwiseMin(p);
            high = high.cwiseMax(p);
        }
    }
    const Eigen::Vector2d axis = 0.5 * (low + high);
    for (const double z : {0.0, 20.0, 50.0}) {
        const double a = twist * z / 50.0;
        Eigen::Matrix2d turn;
        turn << std::cos(a), -std::sin(a), std::sin(a), std::cos(a);
        std::size_t warm = 0;
        const Contour contour = cut_section(*plain.surface, z).value().front();
        for (const auto& p : contour) {
            const Eigen::Vector2d q = axis + turn * (p - axis);
            // The loader's box is that of the facets: its middle may be micrometres off, times the twist.
            EXPECT_NEAR(turned.surface->nearest({q.x(), q.y(), z}, warm).distance_mm, 0.0, 1e-4) << z;
        }
    }
}

TEST_F(PartFile, SectionsByPatternAndMeshWithAHole) {
    for (int k = 0; k < 3; ++k) {
        std::string rows;
        for (int i = 0; i < 60; ++i) {
            const double a = 2.0 * std::numbers::pi * i / 60.0;
            rows += core::fixed(9.0 * std::cos(a), 6) + "," + core::fixed(3.0 * std::sin(a), 6) + "\n";
        }
        write("cut_z" + std::to_string(10 * k) + ".csv", rows);
    }
    const auto part = load("[part]\nname=\"b\"\n[nominal]\nkind=\"sections\"\nfiles=[\"cut_*.csv\"]\n");
    ASSERT_TRUE(part) << part.error().text();
    std::size_t warm = 0;
    EXPECT_NEAR(part->surface->nearest({0.0, 5.0, 10.0}, warm).distance_mm, 2.0, 1e-4);
    EXPECT_TRUE(part->remarks.empty());

    write("open.stl",
          "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
          "0\nendloop\nendfacet\nendsolid\n");
    const auto open =
        load("[part]\nname=\"b\"\n[nominal]\nkind=\"none\"\n[actual]\nkind=\"mesh\"\nfiles=[\"open.stl\"]\n");
    ASSERT_TRUE(open) << open.error().text();
    ASSERT_EQ(open->remarks.size(), 1U);
    EXPECT_NE(open->remarks[0].find("not watertight (3 boundary edges"), std::string::npos);
}

TEST_F(PartFile, APartMayStandAskew) {
    const auto straight = load(parametric);
    const auto placed = load(parametric + "[actual]\nstands_at_mm = [1.5, -2, 0.5]\nstands_turned_deg = [0, 0, 90]\n");
    ASSERT_TRUE(placed) << placed.error().message;
    std::size_t warm = 0, other = 0;
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(3, 8, 20), Eigen::Vector3d(-25, 1, 30)}) {
        const Contact expected = straight->surface->nearest(p, warm);
        // A quarter turn about z takes x to y and y to -x.
        const auto turned = [](const Eigen::Vector3d& v) { return Eigen::Vector3d(-v.y(), v.x(), v.z()); };
        const Eigen::Vector3d shift(1.5, -2, 0.5);
        const Contact found = placed->surface->nearest(turned(p) + shift, other);
        EXPECT_NEAR(found.distance_mm, expected.distance_mm, 1e-9);
        EXPECT_NEAR((found.point - turned(expected.point) - shift).norm(), 0.0, 1e-9);
        EXPECT_NEAR((found.normal - turned(expected.normal)).norm(), 0.0, 1e-9);
    }
    const Box from = straight->surface->box(), to = placed->surface->box();
    EXPECT_NEAR(to.low.x(), -from.high.y() + 1.5, 1e-9);
    EXPECT_NEAR(to.high.y(), from.high.x() - 2.0, 1e-9);
    EXPECT_TRUE(message(parametric + "[actual]\nstands_at_mm = [1, 2]\n").find("three numbers") != std::string::npos);
}

}  // namespace
}  // namespace cmm::sim
