// SPDX-License-Identifier: Apache-2.0
// Real blades through the whole chain over Modbus TCP, with and without a nominal, judged by the simulator's own
// geometry (the exact cut of the part) and its own log of the errors that it injected.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
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
    double worst_mm = 0.0;          // where the surface leans less than 8 degrees
    double worst_leaning_mm = 0.0;  // where it leans more: said, not judged
    double deepest_bridged_mm = 0.0;
    std::size_t judged = 0, leaning = 0, bridged = 0;
};

/// Distance of each contour point to the true cut. In a hollow narrower than the ball the ball stands on both flanks
/// and nobody can know the ground: there the ball that the contour point stands for must touch the part, and how far it
/// does not is the error.
ContourError contour_error(const std::vector<ContourRow>& contour, const sim::Surface& surface,
                           const std::vector<Eigen::Vector2d>& truth, double ball_radius_mm) {
    ContourError error;
    std::size_t warm = 0;
    for (const auto& row : contour) {
        const double lean_deg =
            core::deg_from_rad(std::asin(std::abs(surface.nearest(row.position_mm, warm).normal.z())));
        double off = distance_to_polyline(row.position_mm.head<2>(), truth);
        if (off > contour_limit_mm && lean_deg < truth_lean_deg) {
            Eigen::Vector3d centre = row.position_mm;
            centre.head<2>() += ball_radius_mm * row.normal;
            const double ball_off = std::abs(surface.nearest(centre, warm).distance_mm - ball_radius_mm);
            if (ball_off < 0.5 * off) {
                error.deepest_bridged_mm = std::max(error.deepest_bridged_mm, off);
                ++error.bridged;
                off = ball_off;
            }
        }
        auto& worst = lean_deg < truth_lean_deg ? error.worst_mm : error.worst_leaning_mm;
        worst = std::max(worst, off);
        ++(lean_deg < truth_lean_deg ? error.judged : error.leaning);
    }
    return error;
}

struct Rejections {
    std::size_t points = 0, good = 0, good_lost = 0, bad = 0, bad_missed = 0;
};

Rejections rejections(const std::string& log_file, const std::string& rejected_file) {
    std::set<std::string> rejected;
    for (const auto& row : read_csv(rejected_file))
        rejected.insert(row.at("seq"));
    Rejections counts;
    constexpr int touch_or_no_contact = 1 | 4;
    for (const auto& row : read_csv(log_file)) {
        if ((std::stoi(row.at("flags")) & touch_or_no_contact) != 0) continue;
        ++counts.points;
        const double bad_um = std::abs(std::stod(row.at("bad_um")));
        const bool out = rejected.contains(row.at("seq"));
        if (bad_um == 0.0) {
            ++counts.good;
            counts.good_lost += out ? 1 : 0;
        } else if (bad_um > bad_limit_um) {
            ++counts.bad;
            counts.bad_missed += out ? 0 : 1;
        }
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
        const auto error = contour_error(contour, *truth_part->surface, truth->front(), part.ball_radius_mm);
        EXPECT_LE(error.worst_mm, contour_limit_mm) << part.name << " section " << i << " z " << part.heights_mm[i];
        total.worst_mm = std::max(total.worst_mm, error.worst_mm);
        total.worst_leaning_mm = std::max(total.worst_leaning_mm, error.worst_leaning_mm);
        total.deepest_bridged_mm = std::max(total.deepest_bridged_mm, error.deepest_bridged_mm);
        total.bridged += error.bridged;
        total.judged += error.judged;
        total.leaning += error.leaning;
    }
    const auto counts = rejections(machine.log(), folder / "out/rejected.csv");
    std::printf(
        "%-17s %-8s contour worst %.1f um (lean < 8 deg, %zu points), %.1f um beyond (%zu points), %.1f um bridged "
        "(%zu points); "
        "bad > 40 um %zu, missed %zu; good %zu, lost %zu\n",
        part.name.c_str(), unknown ? "unknown" : "nominal", total.worst_mm * 1e3, total.judged,
        total.worst_leaning_mm * 1e3, total.leaning, total.deepest_bridged_mm * 1e3, total.bridged, counts.bad,
        counts.bad_missed, counts.good, counts.good_lost);
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
