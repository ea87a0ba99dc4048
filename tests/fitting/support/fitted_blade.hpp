// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "fitting/compensation.hpp"
#include "fitting/section.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {

/// A twisted blade in 25 sections, each fitted by itself, and the surface through them.
struct FittedBlade {
    families::TwistedBlade blade;
    families::BladeRows rows;
    std::vector<std::vector<Vec2>> centres;
    std::vector<SectionFit> fits;
    SurfaceCompensation surface{1.0};

    /// `change`: of one row, outwards in mm by the parameter of the place that is touched; bad points it has none then.
    /// `shift_mm`: of that row, as it was measured.
    FittedBlade(families::Family family, std::uint64_t seed, const std::function<double(double)>& change = {},
                std::size_t changed_row = 12, double sigma_mm = 1e-3, const Vec2& shift_mm = Vec2::Zero())
        : blade(family, seed) {
        families::ScanOptions scanning;
        scanning.seed = seed;
        scanning.sigma_mm = sigma_mm;
        if (change) scanning.bad_share = 0.0;
        rows = families::scan_rows(blade, 25, 2.0, blade.height() - 2.0, scanning);
        for (std::size_t k = 0; k < rows.rows.size(); ++k) {
            const auto outline = blade.outline(rows.heights[k]);
            auto& points = centres.emplace_back();
            for (const auto& p : rows.rows[k]) {
                const auto foot = outline.closest(p.head<2>());
                const double by_mm = change && k == changed_row ? change(foot.t) : 0.0;
                points.push_back(p.head<2>() + by_mm * outline.at(foot.t).normal());
                if (k == changed_row) points.back() += shift_mm;
            }
            SectionOptions options;
            options.le_hint = outline.le().nose;
            options.te_hint = outline.te().nose;
            fits.push_back(fit_section(points, {}, options).value());
            EXPECT_TRUE(surface.add(fits.back().centres.curve, rows.heights[k]));
        }
        EXPECT_TRUE(surface.fit());
    }
    bool is_good(std::size_t k, std::size_t i) const { return fits[k].verdicts[i].reason == RejectReason::none; }
};

}  // namespace cmm::fitting
