// SPDX-License-Identifier: Apache-2.0
#include "fitting/compensation.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "bench/bench.hpp"
#include "bench/peer_table.hpp"
#include "fitting/offset.hpp"
#include "support/contour_change.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::bench {
namespace {

using namespace fitting;

constexpr std::size_t sections = 25;
constexpr std::size_t growing_sections = 16;  // the newest, as the program has it while it measures

struct Errors {
    std::vector<double> sides, edges, flat;
};

Errors errors_of(const families::TwistedBlade& blade, const SurfaceCompensation& compensation) {
    Errors errors;
    for (const SurfaceRow& row : compensation.rows()) {
        const auto truth = blade.section(row.z_mm());
        const ContactContour contour = compensation.contour(row.z_mm()).value();
        for (const ContactPoint& p : contour.points) {
            const families::Foot foot = truth.closest(p.position_mm.head<2>());
            const auto part = families::Blade::part_of(foot.t);
            const bool edge = part == families::Part::le || part == families::Part::te;
            (edge ? errors.edges : errors.sides).push_back(foot.distance);
        }
        for (const auto& p : offset_inwards(row.smooth().curve, 1.0, 400).points)
            errors.flat.push_back(truth.closest(p.position).distance);
    }
    return errors;
}

/// 25 sections of 600 points, ball 1 mm.
void bench_blade(const families::TwistedBlade& blade, bool noisy) {
    families::ScanOptions scanning;
    scanning.sigma_mm = noisy ? 1e-3 : 0.0;
    scanning.bad_share = noisy ? 0.015 : 0.0;
    const auto rows = families::scan_rows(blade, sections, 2, blade.height() - 2, scanning);
    SurfaceCompensation growing(1.0, growing_sections), all(1.0);
    double change = 0.0;
    std::vector<double> times;
    for (std::size_t k = 0; k < sections; ++k) {
        std::vector<Vec2> centres;
        for (const Vec3& p : rows.rows[k])
            centres.push_back(p.head<2>());
        SectionOptions options;
        options.le_hint = blade.outline(rows.heights[k]).le().nose;
        options.te_hint = blade.outline(rows.heights[k]).te().nose;
        const auto provisional = growing.contour(rows.heights[k > 0 ? k - 1 : 0]);
        bool taken = false;
        const auto take = [&] { taken = growing.add(centres, rows.heights[k], options) && (k == 0 || growing.fit()); };
        times.push_back(peers::time_ms(1, take).median);
        if (!taken || !all.add(centres, rows.heights[k], options)) {
            std::printf("%s: section %zu refused\n", blade.name().c_str(), k);
            return;
        }
        if (k > 4 && provisional)
            change = std::max(change,
                              families::contour_change_mm(*provisional, growing.contour(rows.heights[k - 1]).value()));
    }
    const double all_ms = peers::time_ms(1, [&] { (void)all.fit(); }).median;
    const Errors errors = errors_of(blade, all);
    std::sort(times.begin(), times.end());
    const std::string name = blade.name() + (noisy ? "" : " without noise");
    print_ms(name + ": a section into the growing surface", {times.front(), times[sections / 2], times.back()},
             "30 ms");
    print_ms(name + ": the surface of all " + std::to_string(sections), {all_ms, all_ms, all_ms}, "");
    std::printf("  sides %s; edges %s; 2-D offset %s; provisional to final %.1f um\n",
                rms_and_max(errors.sides).c_str(), rms_and_max(errors.edges).c_str(), rms_and_max(errors.flat).c_str(),
                1e3 * change);
}

}  // namespace

void bench_compensation() {
    for (const auto family : families::all_families)
        for (const bool noisy : {true, false})
            bench_blade(families::TwistedBlade(family, 1), noisy);
}

}  // namespace cmm::bench
