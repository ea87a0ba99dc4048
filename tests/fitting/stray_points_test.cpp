// SPDX-License-Identifier: Apache-2.0
/// Bad points that their own section does not betray: found by what the others foretell, and nothing else is.
#include "fitting/stray_points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "support/fitted_blade.hpp"

namespace cmm::fitting {
namespace {

StrayPoints strays_of(const FittedBlade& fitted, std::size_t k) {
    return stray_points(fitted.surface, fitted.rows.heights[k], fitted.centres[k], fitted.fits[k].verdicts);
}

/// One to three side by side, most of 20 to 33 um, which the single section takes for its form: of the fans with any,
/// few have more.
TEST(StrayPoints, WhatASectionTakesForItsFormTheOthersBetray) {
    std::size_t missed = 0, found = 0;
    for (const std::uint64_t seed : {12, 24, 63, 114, 136, 168}) {
        const FittedBlade fitted(families::Family::fan, seed);
        SCOPED_TRACE(fitted.blade.name());
        for (std::size_t k = 0; k < fitted.fits.size(); ++k) {
            for (std::size_t i = 0; i < fitted.centres[k].size(); ++i)
                missed += std::abs(fitted.rows.bad[k][i]) >= 0.02 && fitted.is_good(k, i) ? 1 : 0;
            const StrayPoints strays = strays_of(fitted, k);
            for (const auto& stray : strays.bad) {
                const double bad_mm = fitted.rows.bad[k][stray.index];
                EXPECT_NE(bad_mm, 0.0) << "section " << k << ", point " << stray.index;
                EXPECT_NEAR(stray.off_mm, bad_mm, 0.01 + 0.05 * std::abs(bad_mm));
                found += fitted.is_good(k, stray.index) ? 1 : 0;
            }
        }
    }
    EXPECT_GE(missed, 12U);
    EXPECT_EQ(found, missed);
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
            EXPECT_TRUE(strays_of(fitted, k).bad.empty()) << width << " " << k;
    }
}

/// At 4 um of noise 17 good points of a section that was displaced by 25 um were taken for bad.
TEST(StrayPoints, ASectionThatIsDisplacedKeepsItsPoints) {
    const FittedBlade fitted(families::Family::fan, 2, {}, 12, 4e-3, {0.015, 0.02});
    EXPECT_FALSE(fitted.surface.centres()->strays.empty());
    EXPECT_TRUE(strays_of(fitted, 12).bad.empty());
}

TEST(StrayPoints, WhatAnOperatorKeepsStays) {
    FittedBlade fitted(families::Family::fan, 63);
    const auto strays = strays_of(fitted, 9).bad;
    ASSERT_EQ(strays.size(), 4U);
    for (const auto& stray : strays)
        fitted.fits[9].verdicts[stray.index].kept = true;
    EXPECT_TRUE(strays_of(fitted, 9).bad.empty());
}

}  // namespace
}  // namespace cmm::fitting
