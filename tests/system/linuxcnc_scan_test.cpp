// SPDX-License-Identifier: Apache-2.0
// A bar on LinuxCNC itself, measured by the program as a blade, touch by touch: its size, and after the host was killed
// every place once.
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "acquisition/journal.hpp"
#include "core/rng.hpp"
#include "tests/support/linuxcnc_peer.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/resumable_run.hpp"

namespace cmm::test {
namespace {

// The bar of tests/peers/linuxcnc/bodies.hal, upright up to z = -60.
constexpr double bar_x_mm = 300.0, bar_y_mm = 100.0;
constexpr double end_radius_mm = 4.0, bar_chord_mm = 48.0;
constexpr double top_z_mm = -60.0;
// A servo cycle at 2 mm/s, halved by the latch delay: +-1 um a contact, of which some ten make an edge's radius.
constexpr double contact_mm = 0.003;
constexpr double size_mm = 0.005;

std::string machine_text() {
    return std::string("[link]\nurl = \"") + LinuxcncPeer::url +
           "\"\n[linuxcnc]\nreset_estop = true\nlatch_delay_us = " + std::to_string(LinuxcncPeer::latch_delay_us) +
           "\n";
}

const char* const part_text = R"([part]
name = "bar"
kind = "blade"
[nominal]
kind = "sections"
files = ["outline.csv"]
span = "z"
le_hint_mm = [276, 100]
[stylus]
radius_mm = 1.0
shank_radius_mm = 0.6
length_mm = 100.0
[scan]
heights_mm = [-100, -80]
pitch_mm = 8.0
edge_density = 4.0
max_speed_mm_s = 100.0
[gate]
profile_mm = 0.05
edge_profile_mm = 0.05
)";

/// Counter-clockwise round the bar, a twentieth of a millimetre apart.
void write_outline(const std::string& file) {
    constexpr int on_side = 800, on_end = 252;
    const double axis_mm = 0.5 * bar_chord_mm - end_radius_mm;
    std::ofstream out(file);
    out << "x,y,z,section\n";
    for (int section = 0; section < 2; ++section) {
        const auto put = [&](double x, double y) {
            out << bar_x_mm + x << ',' << bar_y_mm + y << ',' << (section == 0 ? top_z_mm - 60.0 : top_z_mm) << ','
                << section << '\n';
        };
        out.precision(12);
        for (const double side : {1.0, -1.0}) {
            for (int k = 0; k < on_side; ++k)
                put(side * axis_mm * (1.0 - 2.0 * k / on_side), side * end_radius_mm);
            for (int k = 0; k < on_end; ++k) {
                const double angle = std::numbers::pi * (0.5 + static_cast<double>(k) / on_end);
                put(side * (-axis_mm + end_radius_mm * std::cos(angle)), side * end_radius_mm * std::sin(angle));
            }
        }
    }
}

void write_text(const std::string& file, const std::string& text) {
    std::ofstream(file) << text;
}

class LinuxcncScan : public testing::Test {
  protected:
    void SetUp() override {
        if (const auto obstacle = LinuxcncPeer::obstacle(); !obstacle.empty()) GTEST_SKIP() << obstacle;
        write_text(machine_, machine_text());
        write_text(part_, part_text);
        write_outline(folder_ / "outline.csv");
        linuxcnc_.emplace(folder_ / "linuxcnc");
        Finished seen;
        const bool up = wait_for([&] {
            seen = run({cmmlive(), "doctor", "--machine", machine_});
            return seen.exit_code == 0 || !linuxcnc_->running();
        });
        ASSERT_TRUE(up && seen.exit_code == 0) << linuxcnc_->said() << seen.out << seen.err;
    }
    std::vector<std::string> command(bool resume) const {
        auto arguments = scan_command(machine_, part_, out_, resume);
        if (!resume) arguments.emplace_back("--touch");
        return arguments;
    }
    /// Ball centres of all places, in the order of the plan.
    std::vector<Eigen::Vector3d> planned() const {
        const auto plan = run({cmmlive(), "plan", "--part", part_, "--touch", "--out", folder_ / "plan.json"});
        EXPECT_EQ(plan.exit_code, 0) << plan.err << plan.out;
        std::ifstream in(folder_ / "plan.json");
        const auto document = nlohmann::json::parse(in);
        std::vector<Eigen::Vector3d> places;
        for (const auto& path : document.at("paths")) {
            for (const auto& row : path.at("points"))
                places.emplace_back(row.at(0).get<double>(), row.at(1).get<double>(), row.at(2).get<double>());
        }
        return places;
    }
    /// The run file holds one contact a place, in their order, where the bar is.
    void expect_every_place_once() const {
        auto journal = acquisition::Journal::read(out_ + "/run.cmmrun");
        ASSERT_TRUE(journal) << journal.error().text();
        const auto samples = (*journal)->samples();
        ASSERT_TRUE(samples) << samples.error().text();
        const auto places = planned();
        std::vector<Eigen::Vector3d> contacts;
        double worst_mm = 0.0;
        for (std::size_t i = 0; i < samples->size(); ++i) {
            EXPECT_EQ((*samples)[i].sequence, i + 1);
            if (!core::of_section((*samples)[i])) continue;
            contacts.push_back(core::centre_mm((*samples)[i], (*journal)->header().lsb_mm));
            if (contacts.size() > places.size()) continue;
            worst_mm = std::max(worst_mm, (contacts.back() - places[contacts.size() - 1]).norm());
        }
        EXPECT_EQ(contacts.size(), places.size());
        EXPECT_LT(worst_mm, contact_mm);
        std::printf("%zu places touched, worst contact %.6f mm beside its place\n", contacts.size(), worst_mm);
    }
    void expect_the_size_of_the_bar() const {
        const auto sections = read_csv(out_ + "/sections.csv");
        ASSERT_EQ(sections.size(), 2U);
        for (const auto& section : sections) {
            for (const auto& [name, size] : {std::pair{"le_radius_mm", end_radius_mm},
                                             {"te_radius_mm", end_radius_mm},
                                             {"chord_mm", bar_chord_mm}}) {
                ASSERT_FALSE(section.at(name).empty()) << name;
                EXPECT_NEAR(std::stod(section.at(name)), size, size_mm) << name;
            }
            std::printf("LE %s, TE %s, chord %s mm\n", section.at("le_radius_mm").c_str(),
                        section.at("te_radius_mm").c_str(), section.at("chord_mm").c_str());
        }
    }

    TemporaryFolder folder_;
    std::string machine_ = folder_ / "machine.toml", part_ = folder_ / "part.toml", out_ = folder_ / "out";
    std::optional<LinuxcncPeer> linuxcnc_;
};

TEST_F(LinuxcncScan, MeasuresABarTouchByTouch) {
    const auto scan = Process(command(false), folder_ / "scan").wait(std::chrono::seconds(400));
    EXPECT_EQ(scan.exit_code, 0) << scan.err << scan.out;
    expect_every_place_once();
    expect_the_size_of_the_bar();
}

TEST_F(LinuxcncScan, AKilledHostLosesNothingAndTouchesNoPlaceTwice) {
    core::Rng rng(2026);
    for (int attempt = 0; attempt < 3; ++attempt) {
        auto arguments = command(attempt > 0);
        const std::string events = folder_ / ("events-" + std::to_string(attempt));
        arguments.insert(arguments.end(), {"--events", events});
        Process scan(arguments, folder_ / ("scan-" + std::to_string(attempt)));
        const std::size_t enough = 5 + rng.below(12);
        const auto touched = [&] {
            std::ifstream in(events);
            std::size_t count = 0;
            for (std::string line; std::getline(in, line);)
                count += line.find("\"SampleBatch\"") != std::string::npos ? 1 : 0;
            return count;
        };
        ASSERT_TRUE(wait_for([&] { return touched() >= enough || !scan.running(); }, std::chrono::seconds(60)));
        // At any instant of a touch, which takes about a second.
        ASSERT_FALSE(wait_for([&] { return !scan.running(); }, std::chrono::milliseconds(1 + rng.below(1200))))
            << scan.err();
        scan.signal(SIGKILL);
        scan.wait(std::chrono::seconds(5));
    }
    const auto last = Process(command(true), folder_ / "last").wait(std::chrono::seconds(400));
    EXPECT_EQ(last.exit_code, 0) << last.err << last.out;
    expect_every_place_once();
    expect_the_size_of_the_bar();
}

}  // namespace
}  // namespace cmm::test
