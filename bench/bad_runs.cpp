// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cmath>
#include <string>

#include "bench/bench.hpp"
#include "fitting/outliers.hpp"
#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::bench {
namespace {

using fitting::families::ScanOptions;

constexpr std::array<std::size_t, 3> scan_points{600, 1000, 2000};
constexpr std::array<double, 7> heights_mm{0.010, 0.015, 0.020, 0.030, 0.050, 0.100, 0.300};

struct Count {
    std::size_t bad = 0, missed = 0, good = 0, lost = 0, open = 0;

    void add(const fitting::families::BladeScan& scan) {
        fitting::SectionOptions options;
        options.ball_radius_mm = ScanOptions{}.ball_mm;
        const auto fit = fitting::fit_section(scan.points, {}, options);
        if (!fit) {
            ++open;
            return;
        }
        for (std::size_t i = 0; i < scan.points.size(); ++i) {
            const bool rejected = fit->verdicts[i].reason != fitting::RejectReason::none;
            ++(scan.bad[i] == 0.0 ? good : bad);
            lost += scan.bad[i] == 0.0 && rejected ? 1 : 0;
            missed += scan.bad[i] != 0.0 && !rejected ? 1 : 0;
        }
    }
    double missed_percent() const { return 100.0 * static_cast<double>(missed) / static_cast<double>(bad); }
    double lost_percent() const { return 100.0 * static_cast<double>(lost) / static_cast<double>(good); }
};

/// So many blades of each family, for each number of points.
std::array<Count, scan_points.size()> count(std::uint64_t blades, ScanOptions scanning) {
    std::array<Count, scan_points.size()> out;
    for (std::size_t k = 0; k < scan_points.size(); ++k)
        for (const double at_edges : {0.8, 0.1})
            for (const auto family : fitting::families::all_families)
                for (std::uint64_t seed = 1; seed <= blades; ++seed) {
                    scanning.points = scan_points[k];
                    scanning.bad_at_edges = at_edges;
                    scanning.seed = seed * 100 + scanning.shortest_run + scan_points[k];
                    out[k].add(fitting::families::scan(fitting::families::make(family, seed), scanning));
                }
    return out;
}

void report(const std::string& what, const std::array<Count, scan_points.size()>& counts) {
    const std::string columns = "(600, 1000, 2000 points)";
    print(what + ": missed", {counts[0].missed_percent(), counts[1].missed_percent(), counts[2].missed_percent()}, "%",
          columns);
    print("  good points lost", {counts[0].lost_percent(), counts[1].lost_percent(), counts[2].lost_percent()}, "%",
          columns);
    for (const Count& count : counts)
        if (count.open > 0) print_one("  not evaluable", static_cast<double>(count.open), "scans", "0");
}

}  // namespace

void bench_bad_runs() {
    ScanOptions scanning;
    report("20 to 400 um, 1 to 3 side by side", count(120, scanning));
    for (std::size_t length = 1; length <= fitting::longest_bad_run; ++length)
        for (const double height_mm : heights_mm) {
            scanning.shortest_run = scanning.longest_run = length;
            scanning.bad_low_mm = scanning.bad_high_mm = height_mm;
            report(std::to_string(std::lround(1e3 * height_mm)) + " um, " + std::to_string(length) + " side by side",
                   count(8, scanning));
        }
}

}  // namespace cmm::bench
