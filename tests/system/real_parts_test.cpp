// SPDX-License-Identifier: Apache-2.0
// Real blades through the whole chain over Modbus TCP, with and without a nominal, judged by the simulator's own
// geometry (the exact cut of the part) and its own log of the errors that it injected.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "core/units.hpp"
#include "sim/section_cut.hpp"
#include "sim/surface.hpp"
#include "tests/support/outputs.hpp"
#include "tests/system/real_parts.hpp"
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

constexpr double contour_limit_mm = 0.030;
constexpr double truth_lean_deg = 8.0;
constexpr double bad_limit_um = 40.0;
constexpr double good_lost_share = 0.002;

struct ContourError {
    double worst_mm = 0.0;          // where the surface leans less than 8 degrees and no hollow is near
    double worst_leaning_mm = 0.0;  // where it leans more: said, not judged
    double worst_hollow_mm = 0.0;   // in and beside hollows that the ball bridges: said, not judged
    std::size_t judged = 0, leaning = 0, hollow = 0;
};

/// Places of the true contour that the ball cannot touch without entering the part elsewhere.
std::vector<Eigen::Vector2d> hollows(const std::vector<Eigen::Vector2d>& truth, const sim::Surface& surface,
                                     double z_mm, double ball_radius_mm) {
    constexpr double entering_mm = 0.030;
    std::vector<Eigen::Vector2d> places;
    std::size_t warm = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
        const Eigen::Vector2d edge = truth[(i + 1) % truth.size()] - truth[i];
        if (edge.norm() <= 0.0) continue;
        const Eigen::Vector2d middle = truth[i] + 0.5 * edge;
        const Eigen::Vector2d centre = middle + ball_radius_mm * Eigen::Vector2d(edge.y(), -edge.x()) / edge.norm();
        const double gap = surface.nearest({centre.x(), centre.y(), z_mm}, warm).distance_mm - ball_radius_mm;
        if (gap < -entering_mm) places.push_back(middle);
    }
    return places;
}

bool near_any(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& places, double reach_mm) {
    return std::any_of(places.begin(), places.end(), [&](const auto& place) { return (place - p).norm() < reach_mm; });
}

constexpr double beside_mm = 1.5;  // beside a hollow: the smoothed corner of the ball's path shows as far as that

ContourError contour_error(const std::vector<ContourRow>& contour, const sim::Surface& surface,
                           const std::vector<Eigen::Vector2d>& truth, const std::vector<Eigen::Vector2d>& places) {
    ContourError error;
    std::size_t warm = 0;
    for (const auto& row : contour) {
        const double lean_deg =
            core::deg_from_rad(std::asin(std::abs(surface.nearest(row.position_mm, warm).normal.z())));
        const double off = distance_to_polyline(row.position_mm.head<2>(), truth);
        const bool hollow = near_any(row.position_mm.head<2>(), places, beside_mm);
        const bool leaning = lean_deg >= truth_lean_deg;
        auto& worst = hollow ? error.worst_hollow_mm : leaning ? error.worst_leaning_mm : error.worst_mm;
        worst = std::max(worst, off);
        ++(hollow ? error.hollow : leaning ? error.leaning : error.judged);
    }
    return error;
}

struct Rejections {
    std::size_t good = 0, good_lost = 0, good_lost_in_hollows = 0, bad = 0, bad_missed = 0;
};

/// `places`: by height, where good points beside a hollow are counted apart.
Rejections rejections(const std::string& log_file, const std::string& rejected_file,
                      const std::map<int, std::vector<Eigen::Vector2d>>& places, double ball_radius_mm) {
    std::set<std::string> rejected;
    for (const auto& row : read_csv(rejected_file))
        rejected.insert(row.at("seq"));
    Rejections counts;
    constexpr int no_contact = 1;
    constexpr int touch = 4;
    for (const auto& row : read_csv(log_file)) {
        if ((std::stoi(row.at("flags")) & (no_contact | touch)) != 0) continue;
        const double bad_um = std::abs(std::stod(row.at("bad_um")));
        const bool out = rejected.contains(row.at("seq"));
        if (bad_um > bad_limit_um) {
            ++counts.bad;
            counts.bad_missed += out ? 0 : 1;
        }
        if (bad_um > 0.0) continue;
        ++counts.good;
        if (!out) continue;
        const Eigen::Vector2d centre(std::stod(row.at("true_x_mm")), std::stod(row.at("true_y_mm")));
        const auto at = places.find(static_cast<int>(std::lround(std::stod(row.at("true_z_mm")) * 100.0)));
        const bool hollow = at != places.end() && near_any(centre, at->second, ball_radius_mm + beside_mm);
        ++(hollow ? counts.good_lost_in_hollows : counts.good_lost);
    }
    return counts;
}

class RealParts : public testing::TestWithParam<std::tuple<int, bool>> {};

TEST_P(RealParts, ComeOutTrue) {
    if (real_data_folder().empty()) GTEST_SKIP() << "no ../shared/data here";
    const auto [index, unknown] = GetParam();
    const TemporaryFolder folder;
    const auto part = real_parts(folder).at(static_cast<std::size_t>(index));
    const std::string file = write_part(part, folder, unknown);
    SimulatedMachine machine(file, folder, {"--speed", "0", "--seed", std::to_string(40 + index)});
    ASSERT_FALSE(machine.url().empty()) << machine.process().wait(std::chrono::seconds(1)).err;
    const auto scan = run({cmmlive(), "scan", "--machine", machine.url(), "--part", file, "--out", folder / "out"},
                          std::chrono::seconds(240));
    ASSERT_EQ(scan.exit_code, 0) << scan.err << scan.out;
    machine.end();

    const auto truth_part = sim::load_part(file);
    ASSERT_TRUE(truth_part) << truth_part.error().text();
    const auto sections = read_csv(folder / "out/sections.csv");
    ASSERT_EQ(sections.size(), part.heights_mm.size());
    ContourError total;
    std::map<int, std::vector<Eigen::Vector2d>> hollow_places;  // by height in 0.01 mm
    for (std::size_t i = 0; i < sections.size(); ++i) {
        EXPECT_EQ(sections[i].at("closed"), "1") << part.name << " section " << i;
        const auto contour = read_contour(folder / ("out/section-" + std::to_string(i) + ".csv"));
        ASSERT_GE(contour.size(), 2000U);
        std::set<std::string> zones;
        for (const auto& row : contour)
            zones.insert(row.zone);
        EXPECT_EQ(zones.size(), 4U) << part.name << " section " << i;
        const auto truth = sim::cut_section(*truth_part->surface, part.heights_mm[i]);
        ASSERT_TRUE(truth) << truth.error().text();
        const double z_mm = part.heights_mm[i];
        const auto& places = hollow_places[static_cast<int>(std::lround(z_mm * 100.0))] =
            hollows(truth->front(), *truth_part->surface, z_mm, part.ball_radius_mm);
        const auto error = contour_error(contour, *truth_part->surface, truth->front(), places);
        EXPECT_LE(error.worst_mm, contour_limit_mm) << part.name << " section " << i << " z " << part.heights_mm[i];
        total.worst_mm = std::max(total.worst_mm, error.worst_mm);
        total.worst_leaning_mm = std::max(total.worst_leaning_mm, error.worst_leaning_mm);
        total.worst_hollow_mm = std::max(total.worst_hollow_mm, error.worst_hollow_mm);
        total.hollow += error.hollow;
        total.judged += error.judged;
        total.leaning += error.leaning;
    }
    const auto counts = rejections(machine.log(), folder / "out/rejected.csv", hollow_places, part.ball_radius_mm);
    std::printf(
        "%-17s %-8s contour worst %.1f um (lean < 8 deg, %zu points), %.1f um where it leans more (%zu), %.1f um in "
        "and beside "
        "hollows that the ball bridges (%zu); bad > 40 um %zu, missed %zu; good %zu, lost %zu, and %zu beside "
        "hollows\n",
        part.name.c_str(), unknown ? "unknown" : "nominal", total.worst_mm * 1e3, total.judged,
        total.worst_leaning_mm * 1e3, total.leaning, total.worst_hollow_mm * 1e3, total.hollow, counts.bad,
        counts.bad_missed, counts.good, counts.good_lost, counts.good_lost_in_hollows);
    EXPECT_GT(counts.bad, 0U);
    EXPECT_EQ(counts.bad_missed, 0U);
    EXPECT_LE(static_cast<double>(counts.good_lost), good_lost_share * static_cast<double>(counts.good));
}

std::string case_name(const testing::TestParamInfo<std::tuple<int, bool>>& tested) {
    const std::array<const char*, 4> names{"EngineBlade", "HannoverRotor1", "HannoverStator1", "Rotor37"};
    return std::string(names.at(static_cast<std::size_t>(std::get<0>(tested.param)))) +
           (std::get<1>(tested.param) ? "Unknown" : "Nominal");
}

INSTANTIATE_TEST_SUITE_P(Blades, RealParts, testing::Combine(testing::Range(0, 4), testing::Bool()), case_name);

}  // namespace
}  // namespace cmm::test
