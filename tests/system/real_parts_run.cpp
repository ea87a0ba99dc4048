// SPDX-License-Identifier: Apache-2.0
#include "tests/system/real_parts_run.hpp"

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
#include "tests/system/simulated_machine.hpp"

namespace cmm::test {
namespace {

constexpr double truth_lean_deg = 8.0;
constexpr double bad_limit_um = 40.0;
constexpr double beside_mm = 1.5;  // a corner of the ball's path that is smoothed shows as far as that
constexpr double elsewhere_mm = 0.05;
constexpr double receding_mm = 0.01;

/// By height in 0.01 mm: ball centres whose ball touches the part elsewhere than at the contour point before them.
using Bridges = std::map<int, std::vector<Eigen::Vector2d>>;

int key_of(double z_mm) {
    return static_cast<int>(std::lround(z_mm * 100.0));
}

bool beside(const std::vector<Eigen::Vector2d>& bridge, const Eigen::Vector2d& centre) {
    return std::any_of(bridge.begin(), bridge.end(),
                       [&](const auto& other) { return (other - centre).norm() < beside_mm; });
}

struct Place {
    Eigen::Vector2d centre;
    double off_mm = 0.0;        // of the contour point from the cut
    double untouched_mm = 0.0;  // of the ball from the part
    double lean_deg = 0.0;
    bool bridged = false;
};

Place place_of(const ContourRow& row, const sim::Surface& surface, const std::vector<Eigen::Vector2d>& cut,
               double ball_radius_mm, std::size_t& warm) {
    Place place;
    const Eigen::Vector2d p = row.position_mm.head<2>();
    place.centre = p + ball_radius_mm * row.normal.head<2>().normalized();
    place.off_mm = distance_to_polyline(p, cut);
    const auto contact = surface.nearest({place.centre.x(), place.centre.y(), row.position_mm.z()}, warm);
    place.untouched_mm = std::abs(contact.distance_mm - ball_radius_mm);
    const double lean = std::asin(std::abs(contact.normal.z()));
    place.lean_deg = core::deg_from_rad(lean);
    // It touches above or below the plane; where the part recedes in between, the cut is farther from the contour than
    // the ball is from the part and the lean explains.
    const double excess = ball_radius_mm * (1.0 / std::max(std::cos(lean), 0.1) - 1.0);
    place.bridged = (contact.point.head<2>() - p).norm() > elsewhere_mm + excess ||
                    place.off_mm - place.untouched_mm > excess + receding_mm;
    return place;
}

void add_contour(const std::vector<Place>& places, const std::vector<Eigen::Vector2d>& bridge, ContourError& error) {
    const auto note = [](double off, double& worst, std::size_t& count) {
        worst = std::max(worst, off);
        ++count;
    };
    for (const auto& place : places) {
        if (place.bridged) {
            note(place.untouched_mm, error.worst_bridge_mm, error.bridged);
        } else if (place.lean_deg >= truth_lean_deg) {
            note(place.off_mm, error.worst_leaning_mm, error.leaning);
        } else if (beside(bridge, place.centre)) {
            note(place.off_mm, error.worst_beside_mm, error.beside);
        } else {
            note(place.off_mm, error.worst_mm, error.judged);
        }
    }
}

Rejections rejections(const std::string& log_file, const std::string& rejected_file, const Bridges& bridges) {
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
        const auto bridge = bridges.find(key_of(std::stod(row.at("true_z_mm"))));
        const bool near = bridge != bridges.end() && beside(bridge->second, centre);
        ++(near ? counts.good_lost_beside : counts.good_lost);
    }
    return counts;
}

}  // namespace

RealPartRun run_real_part(const RealPart& part, bool unknown, int seed) {
    RealPartRun result;
    const TemporaryFolder folder;
    const std::string file = write_part(part, folder, unknown);
    SimulatedMachine machine(file, folder, {"--speed", "0", "--seed", std::to_string(seed)});
    const auto fail = [&](const std::string& why) {
        result.failure = why;
        return result;
    };
    if (machine.url().empty()) return fail(machine.process().wait(std::chrono::seconds(1)).err);
    const auto scan = run({cmmlive(), "scan", "--machine", machine.url(), "--part", file, "--out", folder / "out"},
                          std::chrono::seconds(240));
    machine.end();
    if (scan.exit_code != 0) return fail("exit code " + std::to_string(scan.exit_code) + ": " + scan.err + scan.out);
    const auto true_part = sim::load_part(file);
    if (!true_part) return fail(true_part.error().text());

    Bridges bridges;
    const auto sections = read_csv(folder / "out/sections.csv");
    result.sections = sections.size();
    if (sections.size() != part.heights_mm.size()) return fail("not every section is in sections.csv");
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const double z_mm = part.heights_mm[i];
        const auto cut = sim::cut_section(*true_part->surface, z_mm);
        if (!cut) return fail(cut.error().text());
        if (sections[i].at("closed") != "1") continue;
        ++result.closed;
        const auto contour = read_contour(folder / ("out/section-" + std::to_string(i) + ".csv"));
        if (contour.size() < 2000) return fail("a contour has fewer than 2000 points");
        std::set<std::string> zones;
        for (const auto& row : contour)
            zones.insert(row.zone);
        result.four_zones += zones.size() == 4 ? 1 : 0;
        std::vector<Place> places;
        std::size_t warm = 0;
        auto& bridge = bridges[key_of(z_mm)];
        for (const auto& row : contour) {
            places.push_back(place_of(row, *true_part->surface, cut->front(), part.ball_radius_mm, warm));
            if (places.back().bridged) bridge.push_back(places.back().centre);
        }
        add_contour(places, bridge, result.contour);
    }
    result.points = rejections(machine.log(), folder / "out/rejected.csv", bridges);
    return result;
}

std::string RealPartRun::text() const {
    if (!failure.empty()) return failure;
    std::array<char, 500> line{};
    std::snprintf(line.data(), line.size(),
                  "%zu sections, closed %zu, four zones %zu; contour worst %.1f um (lean < 8 deg, %zu points), %.1f um "
                  "where it leans more (%zu), %.1f um beside hollows (%zu), %.1f um where the ball bridges them (%zu); "
                  "bad > 40 um %zu, missed %zu; good %zu, lost %zu, and %zu beside hollows",
                  sections, closed, four_zones, contour.worst_mm * 1e3, contour.judged, contour.worst_leaning_mm * 1e3,
                  contour.leaning, contour.worst_beside_mm * 1e3, contour.beside, contour.worst_bridge_mm * 1e3,
                  contour.bridged, points.bad, points.bad_missed, points.good, points.good_lost,
                  points.good_lost_beside);
    return line.data();
}

}  // namespace cmm::test
