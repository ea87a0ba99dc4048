// SPDX-License-Identifier: Apache-2.0
/// Bad points on the last sparse points of a side, beside a densely measured edge.
#include <gtest/gtest.h>

#include <cmath>

#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

using families::Blade;
using families::Family;

struct Scanned {
    Blade blade;
    families::BladeScan scan;

    Scanned(Family family, std::uint64_t seed, double bad_share, std::size_t points = 600)
        : blade(families::make(family, seed)), scan(families::scan(blade, options(seed, bad_share, points))) {}

    static families::ScanOptions options(std::uint64_t seed, double bad_share, std::size_t points) {
        families::ScanOptions out;
        out.seed = 77000 + seed;
        out.sigma_mm = 1e-3;
        out.points = points;
        out.bad_share = bad_share;
        return out;
    }

    core::Result<SectionFit> fit() const {
        SectionOptions section;
        section.ball_radius_mm = 1.0;
        section.le_hint = blade.le().nose;
        section.te_hint = blade.te().nose;
        return fit_section(scan.points, {}, section);
    }

    double largest_off_mm(const SectionFit& fit) const {
        double largest = 0.0;
        for (const ContourPoint& p : fit.contour)
            largest = std::max(largest, std::abs(blade.closest(p.position_mm).distance));
        return largest;
    }
};

bool is_bad(const SectionFit& fit, std::size_t i) {
    return fit.verdicts[i].reason != RejectReason::none;
}

/// Of 2 700 blades those where a single section missed some, and its contour was 25 to 114 um off; but for one where a
/// good point beside them is left out still.
TEST(SideEnds, RunsThatAnEdgeExcusedAreFound) {
    for (const auto& [family, seed] :
         {std::pair{Family::fan, 108}, std::pair{Family::fan, 117}, std::pair{Family::fan, 169},
          std::pair{Family::fan, 207}, std::pair{Family::fan, 255}, std::pair{Family::fan, 423},
          std::pair{Family::fan, 332}, std::pair{Family::fan, 458}, std::pair{Family::fan, 498},
          std::pair{Family::fan, 646}, std::pair{Family::fan, 763}, std::pair{Family::turbine, 249},
          std::pair{Family::turbine, 335}}) {
        const Scanned scanned(family, static_cast<std::uint64_t>(seed), 0.015);
        SCOPED_TRACE(scanned.blade.name());
        const auto fit = scanned.fit();
        ASSERT_TRUE(fit) << fit.error().message;
        for (std::size_t i = 0; i < scanned.scan.bad.size(); ++i) {
            const double bad_mm = scanned.scan.bad[i];
            if (bad_mm != 0.0 && std::abs(bad_mm) <= 0.02) continue;
            EXPECT_EQ(is_bad(*fit, i), bad_mm != 0.0) << i << " " << bad_mm;
        }
        EXPECT_LT(scanned.largest_off_mm(*fit), 0.009);
    }
}

/// The last of a run of 31, 41 and 31 um is 4.4 standard deviations off the side, which goes on to its edge without it:
/// kept, it brought back the two others, and the contour was 42 um off.
TEST(SideEnds, WhatTheSideGoesOnWithoutIsBad) {
    Scanned scanned(Family::fan, 2306, 0.015);
    auto scanning = Scanned::options(0, 0.015, 600);
    scanning.seed = 10083;
    scanned.scan = families::scan(scanned.blade, scanning);
    const auto fit = scanned.fit();
    ASSERT_TRUE(fit) << fit.error().message;
    for (std::size_t i = 0; i < scanned.scan.bad.size(); ++i)
        EXPECT_EQ(is_bad(*fit, i), scanned.scan.bad[i] != 0.0) << i << " " << scanned.scan.bad[i];
    EXPECT_LT(scanned.largest_off_mm(*fit), 0.004);
}

/// Two points 0.2 mm out, the fifth and the sixth of a side: the way bends back at them no more than noise makes it do
/// on the edge, where points are 0.02 mm apart, and that is no concave side.
TEST(SideEnds, NoiseOfADenseEdgeFreesNoRun) {
    const Scanned scanned(Family::fan, 154, 0.015, 2000);
    const auto fit = scanned.fit();
    ASSERT_TRUE(fit) << fit.error().message;
    std::size_t bad = 0;
    for (std::size_t i = 0; i < scanned.scan.bad.size(); ++i) {
        if (std::abs(scanned.scan.bad[i]) <= 0.02) continue;
        ++bad;
        EXPECT_TRUE(is_bad(*fit, i)) << i << " " << scanned.scan.bad[i];
    }
    EXPECT_EQ(bad, 30U);
    EXPECT_LT(scanned.largest_off_mm(*fit), 0.003);
}

/// One to three at each end of each side, outwards and inwards.
TEST(SideEnds, RunsOfEveryLengthAreFoundAtEveryEnd) {
    std::size_t runs = 0, missed = 0, lost = 0;
    for (const Family family : families::all_families)
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            const Scanned clean(family, seed, 0.0);
            const std::size_t n = clean.scan.points.size();
            for (std::size_t i = 0; i < n; ++i) {
                const families::Part part = Blade::part_of(clean.scan.t[i]);
                const bool side = part == families::Part::pressure || part == families::Part::suction;
                for (const std::size_t way : {n - 1, std::size_t{1}}) {  // into the side
                    if (!side || Blade::part_of(clean.scan.t[(i + n - way) % n]) == part) continue;
                    for (std::size_t length = 1; length <= 3; ++length)
                        for (const double off_mm : {-0.1, -0.03, 0.03, 0.1}) {
                            Scanned run = clean;
                            for (std::size_t k = 0; k < length; ++k) {
                                const std::size_t at = (i + k * way) % n;
                                run.scan.bad[at] = off_mm * (1.0 + 0.2 * static_cast<double>(k));
                                run.scan.points[at] += run.scan.bad[at] * run.blade.at(run.scan.t[at]).normal();
                            }
                            const auto fit = run.fit();
                            ASSERT_TRUE(fit) << fit.error().message;
                            ++runs;
                            for (std::size_t k = 0; k < n; ++k) {
                                missed += run.scan.bad[k] != 0.0 && !is_bad(*fit, k) ? 1 : 0;
                                lost += run.scan.bad[k] == 0.0 && is_bad(*fit, k) ? 1 : 0;
                            }
                        }
                }
            }
        }
    EXPECT_EQ(runs, 3U * 4U * 4U * 3U * 4U);
    EXPECT_EQ(missed, 0U);
    EXPECT_EQ(lost, 0U);
}

}  // namespace
}  // namespace cmm::fitting
