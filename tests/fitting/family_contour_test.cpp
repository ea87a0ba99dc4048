// SPDX-License-Identifier: Apache-2.0
/// Contours of prismatic blades of the three families against their exact outlines: how far off, and whether the
/// stated uncertainty covers it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>

#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

using families::Family;
using families::Part;

struct Errors {
    double squares = 0.0, count = 0.0, largest_um = 0.0;  // mean over blades of the largest

    void add(double off_um) {
        squares += off_um * off_um;
        count += 1.0;
    }
    double rms_um() const { return std::sqrt(squares / count); }
};

struct FamilyErrors {
    Errors sides, edges;
    double covered = 0.0;  // share of contour points within their U95
};

/// 600 points, 12 % on each edge, ball 1 mm.
FamilyErrors measure(Family family, double sigma_mm, double bad_share) {
    constexpr int blades = 60;
    FamilyErrors all;
    double within = 0.0;
    for (int k = 1; k <= blades; ++k) {
        const families::Blade blade = families::make(family, 300 + k);
        families::ScanOptions scanning;
        scanning.seed = 4000 + k;
        scanning.sigma_mm = sigma_mm;
        scanning.bad_share = bad_share;
        SectionOptions options;
        options.ball_radius_mm = scanning.ball_mm;
        options.le_hint = blade.le().nose;
        options.te_hint = blade.te().nose;
        const auto fit = fit_section(families::scan(blade, scanning).points, {}, options);
        EXPECT_TRUE(fit) << blade.name();
        if (!fit) continue;
        double side = 0.0, edge = 0.0;
        for (const ContourPoint& point : fit->contour) {
            const families::Foot foot = blade.closest(point.position_mm);
            const double off_um = 1e3 * std::abs(foot.distance);
            const Part part = families::Blade::part_of(foot.t);
            const bool on_edge = part == Part::le || part == Part::te;
            (on_edge ? all.edges : all.sides).add(off_um);
            double& largest = on_edge ? edge : side;
            largest = std::max(largest, off_um);
            within += off_um <= 1e3 * point.u95_mm ? 1.0 : 0.0;
        }
        all.sides.largest_um += side / blades;
        all.edges.largest_um += edge / blades;
    }
    all.covered = within / (all.sides.count + all.edges.count);
    std::cout << to_string(family) << ", " << 1e3 * sigma_mm << " um: sides rms " << all.sides.rms_um() << ", largest "
              << all.sides.largest_um << "; edges " << all.edges.rms_um() << ", " << all.edges.largest_um
              << " um; U95 holds at " << 100.0 * all.covered << " %\n";
    return all;
}

TEST(FamilyContour, OneMicrometreOfNoise) {
    for (const Family family : families::all_families) {
        const FamilyErrors all = measure(family, 1e-3, 0.0);
        EXPECT_LT(all.sides.rms_um(), 0.29);
        EXPECT_LT(all.edges.rms_um(), 0.29);
        EXPECT_LT(all.sides.largest_um, 0.9);
        EXPECT_LT(all.edges.largest_um, 0.8);
        EXPECT_GT(all.covered, 0.93);
        EXPECT_LT(all.covered, 0.97);
    }
}

TEST(FamilyContour, IntervalsAtOtherNoise) {
    for (const Family family : families::all_families)
        for (const double sigma_mm : {2e-3, 5e-3}) {
            const double covered = measure(family, sigma_mm, 0.0).covered;
            EXPECT_GT(covered, 0.93);
            EXPECT_LT(covered, 0.97);
        }
}

TEST(FamilyContour, WithoutNoise) {
    for (const Family family : families::all_families) {
        const FamilyErrors all = measure(family, 0.0, 0.0);
        EXPECT_LT(all.sides.rms_um(), 0.005);
        EXPECT_LT(all.edges.rms_um(), 0.005);
        EXPECT_LT(all.sides.largest_um, 0.03);
        EXPECT_LT(all.edges.largest_um, 0.03);
    }
}

}  // namespace
}  // namespace cmm::fitting
