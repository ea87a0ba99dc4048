// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "bench/bench.hpp"
#include "fitting/nominal.hpp"
#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::bench {
namespace {

using fitting::families::Blade;
using fitting::families::BladeScan;

constexpr std::uint64_t blades = 8;  // of each family
constexpr std::size_t places = 48;   // where a gap begins, evenly round
constexpr double ball_mm = 1.0;

/// How far each point of a scan is on the way round the blade, as a share.
std::vector<double> ways(const Blade& blade, const BladeScan& scan) {
    std::vector<std::size_t> order(scan.t.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = i;
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return scan.t[a] < scan.t[b]; });
    std::vector<double> way(order.size());
    double length = 0.0;
    fitting::Vec2 last = blade.ball_centre(scan.t[order[0]], ball_mm);
    for (const std::size_t i : order) {
        const fitting::Vec2 next = blade.ball_centre(scan.t[i], ball_mm);
        length += (next - last).norm();
        way[i] = length;
        last = next;
    }
    const double whole = length + (blade.ball_centre(scan.t[order[0]], ball_mm) - last).norm();
    for (double& w : way)
        w /= whole;
    return way;
}

struct Count {
    std::size_t scans = 0, open = 0, wrong = 0;
    std::vector<double> largest_um;  // of each contour, of what counts as measured
};

fitting::NominalSection nominal_of(const Blade& blade) {
    constexpr int corners = 1200;
    std::vector<fitting::Vec2> points;
    for (int i = 0; i < corners; ++i)
        points.push_back(blade.at(4.0 * i / corners).position);
    return fitting::analyse_nominal(points, {blade.le().nose, blade.te().nose}).value();
}

void add(const Blade& blade, const fitting::NominalSection& nominal, const BladeScan& scan,
         const std::vector<double>& way, double begin, double width, Count& count) {
    std::vector<fitting::Vec2> left;
    for (std::size_t i = 0; i < way.size(); ++i)
        if (way[i] - begin - std::floor(way[i] - begin) >= width) left.push_back(scan.points[i]);
    fitting::SectionOptions options;
    options.ball_radius_mm = ball_mm;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    options.nominal = &nominal.curve();
    ++count.scans;
    const auto fit = fitting::fit_section(left, {}, options);
    if (!fit) {
        ++count.open;
        return;
    }
    double largest = 0.0, largest_ratio = 0.0;
    for (const auto& p : fit->contour) {
        if (!p.measured) continue;
        const double error = std::abs(blade.distance(p.position_mm));
        largest = std::max(largest, error);
        largest_ratio = std::max(largest_ratio, error / p.u95_mm);
    }
    count.largest_um.push_back(largest * 1e3);
    count.wrong += largest > 0.006 && largest_ratio > 2.5 ? 1 : 0;
}

}  // namespace

void bench_gaps() {
    for (const auto family : fitting::families::all_families) {
        Count count;
        for (std::uint64_t seed = 1; seed <= blades; ++seed) {
            const Blade blade = fitting::families::make(family, seed);
            fitting::families::ScanOptions scanning;
            scanning.seed = seed;
            const BladeScan scan = fitting::families::scan(blade, scanning);
            const auto way = ways(blade, scan);
            const auto nominal = nominal_of(blade);
            for (const double width : {0.005, 0.01, 0.02, 0.03, 0.05, 0.08, 0.12, 0.16, 0.2, 0.25, 0.28})
                for (std::size_t place = 0; place < places; ++place)
                    add(blade, nominal, scan, way, static_cast<double>(place) / places, width, count);
        }
        auto& um = count.largest_um;
        std::sort(um.begin(), um.end());
        const std::string what = to_string(family) + ", gaps of 0.5 to 28 %: ";
        print_one(what + "scans", static_cast<double>(count.scans), "");
        print_one(what + "open", static_cast<double>(count.open), "");
        print_one(what + "wrong beside the gap", static_cast<double>(count.wrong), "", "0");
        print(what + "largest error", {um[um.size() / 2], um[um.size() * 99 / 100], um.back()}, "um",
              "(50 %, 99 %, all)");
    }
}

}  // namespace cmm::bench
