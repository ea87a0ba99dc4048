// SPDX-License-Identifier: Apache-2.0
/// Bad points that their own section does not betray: found by what the others foretell, and nothing else is.
#include "fitting/stray_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

/// A twisted blade in 25 sections, each fitted by itself, and the surface through them.
struct FittedBlade {
    families::TwistedBlade blade;
    families::BladeRows rows;
    std::vector<std::vector<Vec2>> centres;
    std::vector<SectionFit> fits;
    SurfaceCompensation surface{1.0};

    /// `change`: of row 12, by the parameter of the place that is touched.
    FittedBlade(families::Family family, std::uint64_t seed, const std::function<double(double)>& change = {})
        : blade(family, seed) {
        families::ScanOptions scanning;
        scanning.seed = seed;
        if (change) scanning.bad_share = 0.0;
        rows = families::scan_rows(blade, 25, 2.0, blade.height() - 2.0, scanning);
        for (std::size_t k = 0; k < rows.rows.size(); ++k) {
            const auto outline = blade.outline(rows.heights[k]);
            auto& points = centres.emplace_back();
            for (const auto& p : rows.rows[k]) {
                const auto foot = outline.closest(p.head<2>());
                const double by_mm = change && k == 12 ? change(foot.t) : 0.0;
                points.push_back(p.head<2>() + by_mm * outline.at(foot.t).normal());
            }
            SectionOptions options;
            options.le_hint = outline.le().nose;
            options.te_hint = outline.te().nose;
            fits.push_back(fit_section(points, {}, options).value());
            EXPECT_TRUE(surface.add(fits.back().centres.curve, rows.heights[k]));
        }
        EXPECT_TRUE(surface.fit());
    }
    StrayPoints strays(std::size_t k) const {
        return stray_points(surface, rows.heights[k], centres[k], fits[k].verdicts);
    }
    bool is_good(std::size_t k, std::size_t i) const { return fits[k].verdicts[i].reason == RejectReason::none; }
};

/// Two and three of 20 to 33 um on an edge or beside it, which the single section takes for its form.
TEST(StrayPoints, WhatASectionTakesForItsFormTheOthersBetray) {
    std::size_t missed = 0, found = 0;
    for (const auto& [family, seed] : {std::pair{families::Family::fan, 7}, std::pair{families::Family::fan, 12},
                                       std::pair{families::Family::fan, 24}, std::pair{families::Family::fan, 28}}) {
        const FittedBlade fitted(family, static_cast<std::uint64_t>(seed));
        SCOPED_TRACE(fitted.blade.name());
        for (std::size_t k = 0; k < fitted.fits.size(); ++k) {
            for (std::size_t i = 0; i < fitted.centres[k].size(); ++i)
                missed += std::abs(fitted.rows.bad[k][i]) >= 0.02 && fitted.is_good(k, i) ? 1 : 0;
            const StrayPoints strays = fitted.strays(k);
            for (const auto& stray : strays.bad) {
                const double bad_mm = fitted.rows.bad[k][stray.index];
                EXPECT_NE(bad_mm, 0.0) << "section " << k << ", point " << stray.index;
                EXPECT_NEAR(stray.off_mm, bad_mm, 0.01 + 0.05 * std::abs(bad_mm));
                found += fitted.is_good(k, stray.index) ? 1 : 0;
            }
        }
    }
    EXPECT_GE(missed, 12U);
    EXPECT_GE(found + 1, missed);
}

/// A dent of seven or eighteen points is the part's, though no other section has it.
TEST(StrayPoints, ADentIsNoRunOfBadPoints) {
    const auto dent = [](double width) {
        return [width](double t) {
            const double x = (t - 3.5) / width;
            return std::abs(x) < 1.0 ? -0.03 * std::pow(1.0 - x * x, 2.0) : 0.0;
        };
    };
    for (const double width : {0.018, 0.04}) {
        const FittedBlade fitted(families::Family::compressor, 2, dent(width));
        EXPECT_FALSE(fitted.surface.centres()->strays.empty());
        for (std::size_t k = 0; k < fitted.fits.size(); ++k)
            EXPECT_TRUE(fitted.strays(k).bad.empty()) << width << " " << k;
    }
}

TEST(StrayPoints, WhatAnOperatorKeepsStays) {
    FittedBlade fitted(families::Family::fan, 28);
    const auto strays = fitted.strays(3).bad;
    ASSERT_EQ(strays.size(), 3U);
    for (const auto& stray : strays)
        fitted.fits[3].verdicts[stray.index].kept = true;
    EXPECT_TRUE(fitted.strays(3).bad.empty());
}

}  // namespace
}  // namespace cmm::fitting
