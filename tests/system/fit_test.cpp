// SPDX-License-Identifier: Apache-2.0
// `cmmlive fit` from every input form gives the contour of the scan that recorded the points.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>

#include "tests/support/outputs.hpp"
#include "tests/support/process.hpp"

namespace cmm::test {
namespace {

struct Recorded {
    std::map<std::string, std::vector<std::array<std::string, 3>>> sections;
};

Recorded recorded_points(const std::string& points_csv) {
    Recorded recorded;
    for (const auto& row : read_csv(points_csv)) {
        recorded.sections[row.at("section")].push_back({row.at("x_mm"), row.at("y_mm"), row.at("z_mm")});
    }
    return recorded;
}

/// Points of contours lie at 64ths of the way between two places of the curve: where one is half-way between two of
/// these, the last decimal decides, and it moves by one, along the contour.
void expect_same_contours(const std::string& expected_dir, const std::string& dir, double tolerance_mm) {
    int moved = 0;
    for (int i = 0; i < 8; ++i) {
        const std::string name = "/section-" + std::to_string(i) + ".csv";
        const auto expected = read_contour(expected_dir + name);
        const auto found = read_contour(dir + name);
        ASSERT_EQ(found.size(), expected.size()) << dir << name;
        for (std::size_t k = 0; k < found.size(); ++k) {
            const Eigen::Vector3d off = found[k].position_mm - expected[k].position_mm;
            if (off.norm() >= tolerance_mm) {
                const Eigen::Vector3d step = expected[(k + 1) % expected.size()].position_mm - expected[k].position_mm;
                const Eigen::Vector3d along = step.normalized();
                ASSERT_LT((off - along.dot(off) * along).norm(), tolerance_mm) << dir << name << " row " << k;
                ASSERT_LT(off.norm(), step.norm() / 64.0 + tolerance_mm) << dir << name << " row " << k;
                ++moved;
            }
            ASSERT_EQ(found[k].zone, expected[k].zone) << dir << name << " row " << k;
        }
    }
    EXPECT_LE(moved, 1) << dir << ": of all points of all sections";
}

class Fit : public testing::Test {
  protected:
    void SetUp() override {
        const auto demo = run({cmmlive(), "demo", "--speed", "0", "--seed", "9", "--out", folder_ / "scan"});
        ASSERT_EQ(demo.exit_code, 0) << demo.err;
        recorded_ = recorded_points(folder_ / "scan/points.csv");
        ASSERT_EQ(recorded_.sections.size(), 8U);
    }

    void expect_fit(const std::string& name, std::vector<std::string> inputs) {
        std::vector<std::string> command{cmmlive(), "fit"};
        command.insert(command.end(), inputs.begin(), inputs.end());
        for (const auto& word :
             {std::string("--part"), std::string("config/parts/demo.toml"), std::string("--out"), folder_ / name}) {
            command.push_back(word);
        }
        const auto fit = run(command);
        EXPECT_EQ(fit.exit_code, 0) << name << fit.err;
        // The files carry micrometre decimals to 0.01 um: that is all the difference there may be.
        expect_same_contours(folder_ / "scan", folder_ / name, 1.1e-5);
    }

    TemporaryFolder folder_;
    Recorded recorded_;
};

TEST_F(Fit, FromTheRunFile) {
    expect_fit("run", {folder_ / "scan/run.cmmrun"});
}

TEST_F(Fit, FromOneCsvWithASectionColumn) {
    expect_fit("points", {folder_ / "scan/points.csv"});
}

TEST_F(Fit, FromOneCsvTheSectionsToldApartByHeight) {
    std::ofstream out(folder_ / "all.csv");
    out << "# every section in one file\nx,y,z\n";
    for (const auto& [name, points] : recorded_.sections) {
        for (const auto& p : points)
            out << p[0] << "," << p[1] << "," << p[2] << "\n";
    }
    out.close();
    expect_fit("all", {folder_ / "all.csv"});
}

TEST_F(Fit, FromOneFileASectionInWhiteSpace) {
    std::vector<std::string> files;
    for (const char* extension : {".xyz", ".asc", ".txt"}) {
        files.clear();
        for (const auto& [name, points] : recorded_.sections) {
            files.push_back(folder_ / ("s" + name + extension));
            std::ofstream out(files.back());
            for (const auto& p : points)
                out << p[0] << "  " << p[1] << "\t" << p[2] << "\n";
        }
        expect_fit(std::string("white") + (extension + 1), files);
    }
}

TEST_F(Fit, FromATurboGridCurve) {
    for (const char* extension : {".crv", ".curve"}) {
        const std::string file = folder_ / (std::string("blade") + extension);
        std::ofstream out(file);
        for (const auto& [name, points] : recorded_.sections) {
            out << "# Blade Profile " << name << "\n";
            for (const auto& p : points)
                out << " " << p[0] << " " << p[1] << " " << p[2] << "\n";
        }
        out.close();
        expect_fit(std::string("crv") + (extension + 1), {file});
    }
}

TEST_F(Fit, PointsOnThePartTakeNoBall) {
    // The contour that the scan gave, fed back as points on the part, comes back as itself.
    const auto fit =
        run({cmmlive(), "fit", folder_ / "scan/section-2.csv", "--stylus-radius", "0", "--out", folder_ / "part"});
    EXPECT_EQ(fit.exit_code, 0) << fit.err;
    std::vector<Eigen::Vector2d> contour;
    for (const auto& row : read_contour(folder_ / "scan/section-2.csv"))
        contour.emplace_back(row.position_mm.head<2>());
    for (const auto& row : read_contour(folder_ / "part/section-0.csv")) {
        ASSERT_LT(distance_to_polyline(row.position_mm.head<2>(), contour), 2e-3);
    }
}

TEST_F(Fit, ABallOtherThanThePartFilesIsSaid) {
    const auto told = [&](const std::string& radius) {
        return run({cmmlive(), "fit", folder_ / "scan/points.csv", "--part", "config/parts/demo.toml",
                    "--stylus-radius", radius, "--out", folder_ / "ball"})
            .err;
    };
    EXPECT_NE(told("1.5").find("warning: the ball's radius is 1.5000 mm by --stylus-radius, not 1.0000 mm as in "
                               "config/parts/demo.toml\n"),
              std::string::npos);
    EXPECT_EQ(told("1"), "");
}

/// An operator restores a rejected point and rejects another: from the run file and from its points.
TEST_F(Fit, FollowsAnOperator) {
    const auto rejected = read_csv(folder_ / "scan/rejected.csv");
    ASSERT_FALSE(rejected.empty());
    const std::string restored = rejected.front().at("seq"), section = rejected.front().at("section");
    std::string other;
    for (const auto& row : read_csv(folder_ / "scan/points.csv")) {
        const bool is_rejected =
            std::any_of(rejected.begin(), rejected.end(), [&](const auto& r) { return r.at("seq") == row.at("seq"); });
        if (row.at("section") == section && !is_rejected) other = row.at("seq");
    }
    for (const char* input : {"scan/run.cmmrun", "scan/points.csv"}) {
        const std::string out = folder_ / "by-operator";
        const auto fit = run({cmmlive(), "fit", folder_ / input, "--part", "config/parts/demo.toml", "--restore",
                              restored, "--reject", other, "--out", out});
        EXPECT_NE(fit.exit_code, 3) << fit.err;
        bool found = false;
        for (const auto& row : read_csv(out + "/rejected.csv")) {
            EXPECT_NE(row.at("seq"), restored) << input;
            if (row.at("seq") == other) {
                found = true;
                EXPECT_EQ(row.at("reason"), "by_operator");
            }
        }
        EXPECT_TRUE(found) << input;
        std::ifstream file(out + "/result.json");
        const auto result = nlohmann::json::parse(file);
        bool kept = false;
        for (const auto& one : result.at("sections"))
            if (one.contains("kept_points")) kept = one.at("kept_points").at(0).at("seq") == std::stoull(restored);
        EXPECT_TRUE(kept) << input;
    }
    const auto wrong =
        run({cmmlive(), "fit", folder_ / "scan/run.cmmrun", "--restore", "99999999", "--out", folder_ / "wrong"});
    EXPECT_EQ(wrong.exit_code, 3);
    EXPECT_NE(wrong.err.find("99999999"), std::string::npos) << wrong.err;
}

TEST_F(Fit, GateAndExportGoOnFromTheRun) {
    // Limits below what the measurement can decide, then a blade that the same limits reject.
    EXPECT_EQ(run({cmmlive(), "gate", folder_ / "scan", "--gate", "config/gates/demo-tight.toml"}).exit_code, 2);
    const auto bad =
        run({cmmlive(), "demo", "--part", "config/parts/demo-bad.toml", "--speed", "0", "--out", folder_ / "bad"});
    EXPECT_EQ(bad.exit_code, 1) << bad.err;
    EXPECT_EQ(run({cmmlive(), "gate", folder_ / "bad", "--gate", "config/gates/demo-tight.toml"}).exit_code, 1);
    EXPECT_EQ(run({cmmlive(), "gate", folder_ / "scan", "--gate", "config/parts/demo.toml"}).exit_code, 0);
    EXPECT_EQ(run({cmmlive(), "export", folder_ / "scan", "--format", "json", "--out", folder_ / "r.json"}).exit_code,
              0);
    EXPECT_EQ(run({cmmlive(), "export", folder_ / "scan", "--format", "html", "--out", folder_ / "r.html"}).exit_code,
              0);
    EXPECT_EQ(
        run({cmmlive(), "export", folder_ / "scan/run.cmmrun", "--format", "csv", "--out", folder_ / "csv"}).exit_code,
        0);
    expect_same_contours(folder_ / "scan", folder_ / "csv", 1e-9);
    EXPECT_EQ(run({cmmlive(), "gate", folder_ / "nothing", "--gate", "config/parts/demo.toml"}).exit_code, 6);
}

/// What was measured elsewhere is written in every form as well, by the same choices as `fit` has.
TEST_F(Fit, ExportTakesPointsAndChoicesToo) {
    const std::string points = folder_ / "scan/points.csv";
    const auto with = [&](std::vector<std::string> command, const std::vector<std::string>& more) {
        command.insert(command.begin(), cmmlive());
        command.insert(command.end(), more.begin(), more.end());
        return run(command);
    };
    const auto content = [](const std::string& file) {
        std::ifstream in(file);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    const std::vector<std::vector<std::string>> inputs{
        {points, "--part", "config/parts/demo.toml", "--reject", "12,15-18"},
        {points, "--stylus-radius", "1"},
        {folder_ / "scan", "--reject", "12"},
        {folder_ / "scan/run.cmmrun", "--part", "config/parts/demo-bad.toml"}};
    for (const auto& input : inputs) {
        EXPECT_LE(with({"fit", "--out", folder_ / "fitted"}, input).exit_code, 2);
        const auto exported = with({"export", "--format", "json", "--out", folder_ / "exported.json"}, input);
        EXPECT_EQ(exported.exit_code, 0) << exported.err;
        const std::string result = content(folder_ / "exported.json");
        EXPECT_GT(result.size(), 1000U);
        EXPECT_EQ(result, content(folder_ / "fitted/result.json")) << input[0];
        const auto qif = with({"export", "--format", "qif", "--out", folder_ / "exported.qif"}, input);
        EXPECT_EQ(qif.exit_code, 0) << qif.err;
    }
    const auto refused = [&](const std::vector<std::string>& input, const std::string& why) {
        const auto told = with({"export", "--format", "csv", "--out", folder_ / "refused"}, input);
        EXPECT_EQ(told.exit_code, 3);
        EXPECT_NE(told.err.find(why), std::string::npos) << told.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "refused"));
    };
    refused({points}, "the points' ball radius is not known");
    refused({folder_ / "scan", "--stylus-radius", "1"}, "the run knows its ball");
    refused({folder_ / "fitted"}, "holds results of point files and no run");
    refused({points, "--stylus-radius", "1", "--reject", "99999999"}, "99999999");
    const auto nothing = with({"export", "--format", "csv", "--out", folder_ / "refused"}, {folder_ / "nothing"});
    EXPECT_EQ(nothing.exit_code, 6) << nothing.err;
}

}  // namespace
}  // namespace cmm::test
