// SPDX-License-Identifier: Apache-2.0
// Blades of the three families, 25 sections, through the whole judgement of a part: what its contours are off the
// formulas, a table, nothing asserted. families_sweep [noise in um] [first seed] [last seed]
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "acquisition/part_judge.hpp"
#include "acquisition/section_finisher.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::acquisition {
namespace {

namespace families = fitting::families;

constexpr std::size_t section_count = 25;

struct Errors {
    double squares = 0.0, largest_um = 0.0;
    std::size_t count = 0, beyond_u95 = 0;
    void add(double error_um, double u95_um) {
        squares += error_um * error_um;
        largest_um = std::max(largest_um, error_um);
        ++count;
        beyond_u95 += error_um > u95_um ? 1 : 0;
    }
    void print() const {
        const double n = static_cast<double>(std::max<std::size_t>(count, 1));
        std::printf("rms %.3f largest %.2f um, beyond U95 %.1f %%", std::sqrt(squares / n), largest_um,
                    100.0 * static_cast<double>(beyond_u95) / n);
    }
};

std::vector<SectionResult> judged(const families::TwistedBlade& blade, const families::BladeRows& rows) {
    PartJudge judge;
    for (std::size_t k = 0; k < rows.rows.size(); ++k) {
        SectionSetup setup;
        setup.index = k;
        setup.z_mm = rows.heights[k];
        setup.le_hint_mm = blade.outline(setup.z_mm).le().nose;
        std::vector<RecordedPoint> points;
        for (const auto& centre : rows.rows[k]) {
            auto& point = points.emplace_back();
            point.sequence = points.size();
            point.centre_mm << centre.x(), centre.y(), setup.z_mm;
        }
        judge.finish(setup, std::move(points));
    }
    judge.complete();
    return judge.take();
}

void measure(families::Family family, std::uint64_t seed, double noise_mm) {
    const families::TwistedBlade blade(family, seed);
    families::ScanOptions scanning;
    scanning.seed = seed;
    scanning.sigma_mm = noise_mm;
    if (noise_mm == 0.0) scanning.bad_share = 0.0;
    const auto rows = families::scan_rows(blade, section_count, 2.0, blade.height() - 2.0, scanning);
    Errors sides, edges;
    std::size_t missed = 0, lost = 0;
    for (const SectionResult& section : judged(blade, rows)) {
        if (!section.fit) continue;
        const auto truth = blade.section(section.z_mm);
        for (const auto& point : section.fit->contour) {
            const families::Foot foot = truth.closest(point.position_mm);
            const auto part = families::Blade::part_of(foot.t);
            const bool on_edge = part == families::Part::le || part == families::Part::te;
            (on_edge ? edges : sides).add(1e3 * std::abs(foot.distance), 1e3 * point.u95_mm);
        }
        for (std::size_t i = 0; i < section.points.size(); ++i) {
            const bool bad = rows.bad[section.index][i] != 0.0;
            const bool used = section.points[i].verdict.reason == fitting::RejectReason::none;
            missed += bad && used ? 1 : 0;
            lost += !bad && !used ? 1 : 0;
        }
    }
    std::printf("%-14s sides ", blade.name().c_str());
    sides.print();
    std::printf("; edges ");
    edges.print();
    std::printf("; bad points missed %zu, good ones lost %zu\n", missed, lost);
    std::fflush(stdout);
}

}  // namespace
}  // namespace cmm::acquisition

int main(int argc, char** argv) {
    const double noise_um = argc > 1 ? std::atof(argv[1]) : 1.0;
    const int first = argc > 2 ? std::atoi(argv[2]) : 1, last = argc > 3 ? std::atoi(argv[3]) : 12;
    for (const auto family : cmm::fitting::families::all_families)
        for (int seed = first; seed <= last; ++seed)
            cmm::acquisition::measure(family, static_cast<std::uint64_t>(seed), 1e-3 * noise_um);
    return 0;
}
