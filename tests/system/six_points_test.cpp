// SPDX-License-Identifier: Apache-2.0
// A column that stands askew on the simulated machine and is found by six datum points, over the wire.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "acquisition/journal.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

/// An elliptic column that leans and tapers, 60 mm high, closed by flat ends, as a mesh and as a part file.
class Column {
  public:
    explicit Column(const TemporaryFolder& folder) : folder_(folder) { write_mesh(folder / "column.ply"); }

    static double half_x(double z) { return 20.0 - 0.05 * z; }
    static double half_y(double z) { return 6.0 - 0.01 * z; }
    static Eigen::Vector2d middle(double z) { return {0.05 * z, 0.03 * z}; }
    /// Upper, and lower with -1.
    static std::string side(double x, double z, double upper = 1.0) {
        const double y = upper * half_y(z) * std::sqrt(1.0 - x * x / (half_x(z) * half_x(z)));
        return place(middle(z).x() + x, middle(z).y() + y, z);
    }
    /// At the end of smallest x, and of largest with -1.
    static std::string nose(double z, double left = 1.0) {
        return place(middle(z).x() - left * half_x(z), middle(z).y(), z);
    }

    struct Stand {
        Eigen::Vector3d at_mm = Eigen::Vector3d::Zero(), turned_deg = Eigen::Vector3d::Zero();
        Eigen::Isometry3d motion() const {
            const Eigen::Vector3d turn = turned_deg * (std::numbers::pi / 180.0);
            Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
            if (turn.norm() > 0.0) out.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
            out.translation() = at_mm;
            return out;
        }
    };
    /// `alignment`: the keys of that table before its points; none: without an alignment.
    /// `thicken_mm`: too thick by that; then the first five points are middles of two touches.
    std::string part(const std::string& name, const Stand& stand, double noise_um,
                     const std::optional<std::string>& alignment = "kind = \"six_points\"\n",
                     double thicken_mm = 0.0) const {
        const std::string file = folder_ / (name + ".toml");
        std::ofstream out(file);
        out << "[part]\nname = \"column\"\n[nominal]\nkind = \"mesh\"\nfiles = [\"column.ply\"]\nspan = \"z\"\n"
            << "[stylus]\nradius_mm = 1.0\nlength_mm = 70.0\n"
            << "[scan]\nheights_mm = [20, 40]\npitch_mm = 0.5\nmax_speed_mm_s = 20\nwait_s = 0\n"
            << "[gate]\nprofile_mm = 0.05\nedge_profile_mm = 0.05\n";
        if (alignment) {
            out << "[alignment]\n" << *alignment;
            const auto datum = [&](const std::string& at, const std::string& opposite) {
                out << "[[alignment.point]]\nat_mm = " << at << "\n";
                if (thicken_mm != 0.0) out << "opposite_mm = " << opposite << "\n";
            };
            datum(side(-10, 10), side(-10, 10, -1));
            datum(side(10, 10), side(10, 10, -1));
            datum(side(0, 50), side(0, 50, -1));
            datum(nose(10), nose(10, -1));
            datum(nose(50), nose(50, -1));
            out << "[[alignment.point]]\nat_mm = [3.0, 1.8, 60]\ndirection = [0, 0, 1]\n";
        }
        out << "[actual]\nnoise_um = " << noise_um << "\nbad_points_percent = 0.0\nthicken_mm = " << thicken_mm << "\n"
            << "stands_at_mm = " << list(stand.at_mm) << "\nstands_turned_deg = " << list(stand.turned_deg) << "\n";
        return file;
    }

  private:
    static std::string place(double x, double y, double z) { return list({x, y, z}); }
    static std::string list(const Eigen::Vector3d& v) {
        std::ostringstream text;
        text.precision(10);
        text << "[" << v.x() << ", " << v.y() << ", " << v.z() << "]";
        return text.str();
    }
    static void write_mesh(const std::string& file) {
        constexpr int facets = 720;
        constexpr double height_mm = 60.0;
        std::ofstream ply(file);
        ply << "ply\nformat ascii 1.0\nelement vertex " << 2 * facets + 2 << "\nproperty double x\nproperty double y\n"
            << "property double z\nelement face " << 4 * facets
            << "\nproperty list uchar int vertex_indices\nend_header\n";
        ply.precision(12);
        for (const double z : {0.0, height_mm}) {
            for (int k = 0; k < facets; ++k) {
                const double angle = 2.0 * std::numbers::pi * k / facets;
                ply << middle(z).x() + half_x(z) * std::cos(angle) << ' ' << middle(z).y() + half_y(z) * std::sin(angle)
                    << ' ' << z << '\n';
            }
        }
        for (const double z : {0.0, height_mm})
            ply << middle(z).x() << ' ' << middle(z).y() << ' ' << z << '\n';
        for (int k = 0; k < facets; ++k) {
            const int next = (k + 1) % facets;
            ply << "3 " << k << ' ' << next << ' ' << facets + next << '\n'
                << "3 " << k << ' ' << facets + next << ' ' << facets + k << '\n'
                << "3 " << 2 * facets << ' ' << next << ' ' << k << '\n'
                << "3 " << 2 * facets + 1 << ' ' << facets + k << ' ' << facets + next << '\n';
        }
    }
    const TemporaryFolder& folder_;
};

/// 0.8 mm and half a degree off, in every direction.
const Column::Stand askew{{0.5, -0.4, 0.48}, {0.3, -0.2, 0.36}};

nlohmann::json result_of(const std::string& out) {
    std::ifstream in(out + "/result.json");
    return nlohmann::json::parse(in, nullptr, false);
}

Eigen::Isometry3d motion_in(const nlohmann::json& result) {
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 4; ++k)
            motion.matrix()(i, k) = result.at("part_frame").at("machine_from_part").at(i).at(k).get<double>();
    return motion;
}

/// What shift and turn of the frame are off the part as it stands, in units of their standard uncertainties.
Eigen::Matrix<double, 6, 1> frame_errors(const nlohmann::json& result) {
    const auto wrong = askew.motion().inverse() * motion_in(result);
    const auto& frame = result.at("part_frame");
    Eigen::Vector3d about;
    for (int k = 0; k < 3; ++k)
        about[k] = frame.at("about_mm").at(k).get<double>();
    const Eigen::AngleAxisd turn(wrong.linear());
    Eigen::Matrix<double, 6, 1> error;
    error << wrong * about - about, turn.angle() * turn.axis();
    for (int k = 0; k < 6; ++k)
        error[k] /= std::sqrt(frame.at("covariance").at(k).at(k).get<double>());
    return error;
}

/// Largest distance of a contour to the other's, mm.
double apart_mm(const std::string& out, const std::string& other, int section) {
    const std::string name = "/section-" + std::to_string(section) + ".csv";
    std::vector<Eigen::Vector2d> closed;
    for (const auto& row : read_contour(other + name))
        closed.emplace_back(row.position_mm.head<2>());
    double worst = 0.0;
    const auto contour = read_contour(out + name);
    for (const auto& row : contour)
        worst = std::max(worst, distance_to_polyline(row.position_mm.head<2>(), closed));
    return contour.empty() || closed.empty() ? 1e9 : worst;
}

class SixPoints : public testing::Test {
  protected:
    Finished scan(const std::string& part, const std::string& out, bool resume = false) {
        machine_.reset();
        machine_folder_ = std::make_unique<TemporaryFolder>();
        machine_ = std::make_unique<SimulatedMachine>(part, *machine_folder_, std::vector<std::string>{"--speed", "0"});
        EXPECT_FALSE(machine_->url().empty()) << machine_->process().out();
        return Process(scan_command(*machine_, part, out, resume), folder_ / "scan").wait(std::chrono::seconds(120));
    }
    TemporaryFolder folder_;
    Column column_{folder_};
    std::unique_ptr<TemporaryFolder> machine_folder_;  // its own for each: the URL is read from a file there
    std::unique_ptr<SimulatedMachine> machine_;
};

TEST_F(SixPoints, APartThatStandsAskewIsMeasuredAsIfItStoodStraight) {
    const std::string straight = folder_ / "straight", found = folder_ / "found", blind = folder_ / "blind";
    const auto plain = scan(column_.part("straight", {}, 0.0, std::nullopt), straight);
    ASSERT_EQ(plain.exit_code, 0) << plain.err << plain.out;
    const auto aligned = scan(column_.part("askew", askew, 0.0), found);
    ASSERT_EQ(aligned.exit_code, 0) << aligned.err << aligned.out;
    EXPECT_NE(aligned.err.find("aligned by six datum points (RPS)"), std::string::npos) << aligned.err;
    const auto result = result_of(found);
    const auto motion = motion_in(result);
    for (const Eigen::Vector3d& corner : {Eigen::Vector3d(-20, 0, 20), Eigen::Vector3d(20, 0, 40)})
        EXPECT_LT((motion * corner - askew.motion() * corner).norm(), 2e-3);
    EXPECT_GE(result.at("part_frame").at("rounds").get<int>(), 2);
    EXPECT_LT(result.at("part_frame").at("condition").get<double>(), 10.0);
    for (const auto& residual : result.at("part_frame").at("residual_mm"))
        EXPECT_LT(std::abs(residual.get<double>()), 5e-3);
    for (const int section : {0, 1}) {
        EXPECT_LT(apart_mm(found, straight, section), 1.5e-3);
        EXPECT_EQ(result.at("sections").at(section).at("alignment").at("kind"), "six_points");
    }
    std::ifstream report(found + "/report.html");
    const std::string html(std::istreambuf_iterator<char>(report), {});
    EXPECT_NE(html.find("by six datum points (RPS)"), std::string::npos);
    // Without them the same part is out by what it stands askew.
    const auto lost = scan(column_.part("blind", askew, 0.0, std::nullopt), blind);
    EXPECT_EQ(lost.exit_code, 1) << lost.err << lost.out;
    EXPECT_GT(apart_mm(blind, straight, 0), 0.1);

    // The run file, judged again or played again, says the same.
    const auto again = run({cmmlive(), "fit", found + "/run.cmmrun", "--out", folder_ / "again"});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    const auto played = run({cmmlive(), "replay", found, "--out", folder_ / "played"}, std::chrono::seconds(60));
    EXPECT_EQ(played.exit_code, 0) << played.err;
    for (const auto& out : {folder_ / "again", folder_ / "played"}) {
        EXPECT_EQ(result_of(out).at("part_frame"), result.at("part_frame"));
        EXPECT_EQ(result_of(out).at("sections"), result.at("sections"));
        for (const int section : {0, 1})
            EXPECT_EQ(apart_mm(out, found, section), 0.0);
    }
}

TEST_F(SixPoints, MiddlesFindAPartThatIsTooThickWhereItStands) {
    const std::string found = folder_ / "found";
    const auto thick = column_.part("thick", askew, 0.0, "kind = \"rps\"\n", 0.12);
    const auto planned = run({cmmlive(), "plan", "--part", thick, "--json"});
    ASSERT_EQ(planned.exit_code, 0) << planned.err;
    const auto plan = nlohmann::json::parse(planned.out);
    EXPECT_GT(plan.at("alignment_s").get<double>(), 20.0) << "eleven touches thrice";
    EXPECT_GT(plan.at("duration_s").get<double>(), plan.at("alignment_s").get<double>());
    const auto aligned = scan(thick, found);
    ASSERT_EQ(aligned.exit_code, 1) << "the profiles are out; " << aligned.err << aligned.out;
    const auto result = result_of(found);
    const auto motion = motion_in(result);
    // The end of the column is one touch: the part is 60 um longer there, and its axis leans.
    const Eigen::Isometry3d truth = askew.motion() * Eigen::Translation3d(0.05 * 0.06, 0.03 * 0.06, 0.06);
    for (const Eigen::Vector3d& corner : {Eigen::Vector3d(-20, 0, 20), Eigen::Vector3d(20, 0, 40)})
        EXPECT_LT((motion * corner - truth * corner).norm(), 2e-3) << (motion * corner - truth * corner).transpose();
    const auto& excess = result.at("part_frame").at("excess_mm");
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_NEAR(excess.at(i).get<double>(), 0.12, 0.1 * 0.06 + 0.001) << i << ": 60 um higher up a wall that leans";
    EXPECT_TRUE(excess.at(5).is_null());
    EXPECT_NE(aligned.err.find("middle of two touches, +0.1"), std::string::npos) << aligned.err;
    // Kept with the run.
    const auto again = run({cmmlive(), "fit", found + "/run.cmmrun", "--out", folder_ / "again"});
    EXPECT_EQ(again.exit_code, 1) << again.err;
    EXPECT_EQ(result_of(folder_ / "again").at("part_frame"), result.at("part_frame"));
}

TEST_F(SixPoints, NoiseOfTheTouchesIsInTheUncertainty) {
    const std::string found = folder_ / "found";
    const auto aligned = scan(column_.part("askew", askew, 1.0), found);
    ASSERT_EQ(aligned.exit_code, 0) << aligned.err << aligned.out;
    const auto result = result_of(found);
    for (const double error : frame_errors(result))
        EXPECT_LT(std::abs(error), 4.0);
}

/// The touches err by the same machine as the points: what is off in both is off in none, and the rest is stated.
TEST_F(SixPoints, WhatTheMachineDoesToTheTouchesCounts) {
    const std::string part = column_.part("erring", askew, 0.2), found = folder_ / "found";
    std::ofstream(part, std::ios::app)
        << "ball_error_um = 0.9\nlobes_um = 0.7\nscale_um_m = [3, -3, 2]\nsquareness_um_m = [3, 2, -3]\n"
           "growth_um_m = 40\n[uncertainty]\nlength_um = 1.5\nlength_k_mm_per_um = 300\nprobing_form_um = 1.6\n"
           "probing_size_um = 1.9\ntemperature_standard_k = 2\nexpansion_um_m_k = 11.5\n";
    const auto aligned = scan(part, found);
    ASSERT_EQ(aligned.exit_code, 0) << aligned.err << aligned.out;
    const auto result = result_of(found);
    for (const double error : frame_errors(result))
        EXPECT_LT(std::abs(error), 3.0);
    std::size_t off = 0, rows = 0;
    for (const int section : {0, 1}) {
        for (const auto& row : read_csv(found + "/section-" + std::to_string(section) + ".csv")) {
            if (row.at("deviation_mm").empty()) continue;
            ++rows;
            off += std::abs(std::stod(row.at("deviation_mm"))) > std::stod(row.at("u95_mm")) ? 1 : 0;
        }
    }
    EXPECT_GT(rows, 4000U);
    EXPECT_LT(static_cast<double>(off), 0.05 * static_cast<double>(rows));
    // Read back from the run file, the points of the touches are still known.
    const auto again = run({cmmlive(), "fit", found + "/run.cmmrun", "--out", folder_ / "again"});
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_EQ(result_of(folder_ / "again").at("part_frame"), result.at("part_frame"));
    EXPECT_EQ(result_of(folder_ / "again").at("sections"), result.at("sections"));
}

TEST_F(SixPoints, AMissingDatumLeavesTheMachineStoppedAboveIt) {
    const std::string part = column_.part("low", {{0.0, 0.0, -8.0}, {0, 0, 0}}, 0.0);
    const auto ended = scan(part, folder_ / "out");
    EXPECT_EQ(ended.exit_code, 4) << ended.out;
    EXPECT_NE(ended.err.find("at datum point 6"), std::string::npos) << ended.err;
    EXPECT_NE(ended.err.find("machine: stopped"), std::string::npos) << ended.err;
    EXPECT_EQ(state_of(*machine_).state, "stopped");
    const auto doctor = run({cmmlive(), "doctor", "--machine", machine_->url()});
    EXPECT_NE(doctor.out.find("at 3.000 1.800 64.000 mm"), std::string::npos) << doctor.out;
}

TEST_F(SixPoints, OneThatDoesNotSettleLeavesTheMachineStopped) {
    // Noise of 20 um, and 1 um is asked for.
    const auto ended = scan(
        column_.part("noisy", askew, 20.0, "kind = \"rps\"\nresidual_mm = 0.001\nmost_rounds = 4\n"), folder_ / "out");
    EXPECT_EQ(ended.exit_code, 3) << ended.out << ended.err;
    EXPECT_NE(ended.err.find("does not settle in 4 rounds"), std::string::npos) << ended.err;
    EXPECT_EQ(state_of(*machine_).state, "stopped");
}

TEST_F(SixPoints, AKilledHostBeginsTheTouchesAnewAndDoublesNothing) {
    const std::string part = column_.part("askew", askew, 0.0), out = folder_ / "out";
    SimulatedMachine machine(part, folder_, {"--speed", "20"});
    ASSERT_FALSE(machine.url().empty()) << machine.process().out();
    for (int attempt = 0; attempt < 2; ++attempt) {
        const auto before = log_size(machine);
        Process scan(scan_command(machine, part, out, attempt > 0), folder_ / ("scan-" + std::to_string(attempt)));
        ASSERT_TRUE(
            wait_for([&] { return !scan.running() || log_size(machine) > before + 300; }, std::chrono::seconds(60)));
        ASSERT_TRUE(scan.running()) << scan.err();
        scan.signal(SIGKILL);
        scan.wait(std::chrono::seconds(5));
    }
    EXPECT_TRUE(acquisition::Journal::read(out + "/run.cmmrun").value()->part_frame()->empty());
    const auto last = Process(scan_command(machine, part, out, true), folder_ / "last").wait(std::chrono::seconds(120));
    EXPECT_EQ(last.exit_code, 0) << last.err << last.out;
    machine.end();
    expect_every_sample_once(out + "/run.cmmrun", machine.log());
    const auto played = run({cmmlive(), "replay", out, "--out", folder_ / "played"}, std::chrono::seconds(60));
    EXPECT_EQ(played.exit_code, 0) << played.err;
    EXPECT_EQ(result_of(folder_ / "played").at("sections"), result_of(out).at("sections"));
}

TEST_F(SixPoints, PointsThatLeaveAMotionFreeAreRefused) {
    const std::string file = folder_ / "free.toml";
    std::ofstream(file) << "[part]\nname = \"c\"\n[nominal]\nkind = \"mesh\"\nfiles = [\"column.ply\"]\nspan = \"z\"\n"
                           "[scan]\nheights_mm = [20]\n[alignment]\nkind = \"six_points\"\n"
                        << [] {
                               std::string points;
                               for (const double x : {-10.0, -5.0, 0.0, 5.0, 10.0, 12.0})
                                   points += "[[alignment.point]]\nat_mm = " + Column::side(x, 30) + "\n";
                               return points;
                           }();
    const auto refused = run({cmmlive(), "plan", "--part", file});
    EXPECT_EQ(refused.exit_code, 3) << refused.out;
    EXPECT_NE(refused.err.find("the six datum points do not hold the part"), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("free is a"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace cmm::test
