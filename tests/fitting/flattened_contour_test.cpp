// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

using families::Vec2;

constexpr double top_t = 3.5, height_mm = 0.020, width = 0.02, sigma_mm = 2e-3;

double swelling(double t) {
    const double from_top = (t - top_t) / width;
    return height_mm * std::exp(-0.5 * from_top * from_top);
}

/// A narrow place, 20 um high and some 25 points wide at 2 um of noise: the contour leaves out a part of it, and says
/// at its top that it may. Elsewhere it says next to nothing, and the same wherever the scan began.
TEST(FlattenedContour, SaysAtItsTopWhatANarrowPlaceMayBeHigher) {
    double left_out_mm = 0.0, said_mm = 0.0, elsewhere_mm = 0.0;
    std::size_t places = 0;
    constexpr int scans = 24;
    for (std::uint64_t seed = 1; seed <= scans; ++seed) {
        const auto blade = families::make(families::Family::compressor, seed);
        families::ScanOptions scanning;
        scanning.sigma_mm = sigma_mm;
        scanning.bad_share = 0.0;
        scanning.seed = seed;
        auto scan = families::scan(blade, scanning);
        for (std::size_t i = 0; i < scan.points.size(); ++i)
            scan.points[i] += swelling(scan.t[i]) * blade.at(scan.t[i]).normal();
        const auto fit = fit_section(scan.points, {}, {});
        ASSERT_TRUE(fit) << fit.error().text();
        const Vec2 top = blade.at(top_t).position;
        const ContourPoint* highest = &fit->contour.front();
        for (const ContourPoint& point : fit->contour) {
            if ((point.position_mm - top).norm() < (highest->position_mm - top).norm()) highest = &point;
            if ((point.position_mm - top).norm() < 0.2 * blade.shape().chord) continue;
            elsewhere_mm += point.flattened_mm;
            ++places;
        }
        left_out_mm += (height_mm - blade.distance(highest->position_mm)) / scans;
        said_mm += highest->flattened_mm / scans;

        std::rotate(scan.points.begin(), scan.points.begin() + 131, scan.points.end());
        const auto other = fit_section(scan.points, {}, {});
        ASSERT_TRUE(other);
        ASSERT_EQ(other->contour.size(), fit->contour.size());
        for (std::size_t i = 0; i < fit->contour.size(); i += 7)
            EXPECT_NEAR(other->contour[i].flattened_mm, fit->contour[i].flattened_mm, 1e-5) << i;
    }
    elsewhere_mm /= static_cast<double>(places);
    EXPECT_GT(left_out_mm, 0.5e-3) << "else there is nothing to say";
    EXPECT_GT(said_mm, 0.1 * left_out_mm);
    EXPECT_GT(said_mm, 8.0 * elsewhere_mm);
    EXPECT_LT(elsewhere_mm, 0.02 * sigma_mm);
}

}  // namespace
}  // namespace cmm::fitting
