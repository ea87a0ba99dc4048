// SPDX-License-Identifier: Apache-2.0
/// One section has a dent where an edge ends: there its nose, its joints and its turning are unlike the others'. What
/// the sections know together must not follow it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <ostream>

#include "support/fitted_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t first = 0, middle = 12, last = 24;

struct Dent {
    families::Family family;
    std::uint64_t seed;
    double joint;  ///< of an edge's arc and a side: parameter of the outline
    std::size_t row;
    double height_mm = -0.2;   ///< outwards
    double half_width = 0.06;  ///< by parameter
};

void PrintTo(const Dent& dent, std::ostream* out) {
    *out << "family " << static_cast<int>(dent.family) << ", seed " << dent.seed << ", " << dent.height_mm
         << " mm at joint " << dent.joint << " of row " << dent.row;
}

class DentedRows : public testing::TestWithParam<Dent> {};

TEST_P(DentedRows, SpoilNoOthers) {
    const Dent dent = GetParam();
    const auto height_at = [&](double t) {
        const double x = (t - dent.joint) / dent.half_width;
        return std::abs(x) < 1.0 ? dent.height_mm * (0.5 + 0.5 * std::cos(std::numbers::pi * x)) : 0.0;
    };
    const FittedBlade fitted(dent.family, dent.seed, height_at, dent.row);
    ASSERT_TRUE(fitted.surface.centres());
    for (const Stray& stray : fitted.surface.centres()->strays)
        EXPECT_EQ(stray.row, dent.row) << "at u " << stray.u;
    for (std::size_t k = 0; k < fitted.fits.size(); ++k) {
        if (k == dent.row) continue;
        const double z = fitted.rows.heights[k];
        const auto contour = fitted.surface.contour(z, 400);
        ASSERT_TRUE(contour);
        const auto truth = fitted.blade.section(z);
        double largest = 0.0;
        for (const ContactPoint& point : contour->points)
            largest = std::max(largest, std::abs(truth.closest(point.position_mm.head<2>()).distance));
        EXPECT_LT(largest, 2.5e-3) << "section " << k;
    }
}

using families::Family;
INSTANTIATE_TEST_SUITE_P(
    AtAnEdgesEnd, DentedRows,
    testing::Values(Dent{Family::compressor, 2, 1.0, middle}, Dent{Family::compressor, 1, 2.0, middle},
                    Dent{Family::compressor, 2, 3.0, middle}, Dent{Family::compressor, 1, 4.0, middle},
                    Dent{Family::compressor, 4, 3.0, middle}, Dent{Family::compressor, 7, 4.0, middle},
                    Dent{Family::compressor, 6, 4.0, middle}, Dent{Family::turbine, 1, 2.0, middle},
                    Dent{Family::turbine, 2, 4.0, middle}, Dent{Family::fan, 1, 3.0, middle},
                    Dent{Family::fan, 2, 1.0, middle}, Dent{Family::compressor, 2, 2.0, first},
                    Dent{Family::compressor, 3, 1.0, last}, Dent{Family::turbine, 1, 3.0, last},
                    Dent{Family::fan, 1, 4.0, first}, Dent{Family::compressor, 2, 1.0, middle, 0.2, 0.02},
                    Dent{Family::turbine, 2, 2.0, 8, 0.2, 0.03}));

}  // namespace
}  // namespace cmm::fitting
