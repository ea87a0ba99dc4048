// SPDX-License-Identifier: Apache-2.0
/// Rows of a blade that turns, sweeps and leans unevenly over z, at uneven heights, are no cubics over z: what they
/// have in common must not take that for a row that lies apart.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <optional>
#include <vector>

#include "fitting/closed_curve.hpp"
#include "fitting/settled_rows.hpp"
#include "fitting/surface_cut.hpp"
#include "fitting/surface_fit.hpp"
#include "support/families.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr double ball_mm = 1.0;
constexpr std::size_t row_count = 25, parts_of_a_span = 40;

struct Unevenness {
    families::Family family;
    double twist_rad, wave_rad, phase;  // from root to tip; of a sine over the height
};

void PrintTo(const Unevenness& blade, std::ostream* out) {
    *out << "family " << static_cast<int>(blade.family) << ", twist " << blade.twist_rad << ", wave " << blade.wave_rad
         << " at " << blade.phase;
}

/// One section, moved from height to height.
class UnevenTwist : public testing::TestWithParam<Unevenness> {
  protected:
    static std::vector<Vec2> section() {
        const families::TwistedBlade blade(GetParam().family, 3);
        const families::Blade outline = blade.outline(0.5 * blade.height());
        std::vector<Vec2> points;
        using families::Part;
        for (const auto part : {Part::le, Part::pressure, Part::te, Part::suction}) {
            const std::size_t n = part == Part::le || part == Part::te ? 72 : 228;
            std::vector<double> shares;
            for (std::size_t i = 0; i < n; ++i)
                shares.push_back((static_cast<double>(i) + 0.4) / static_cast<double>(n));
            for (const double t : outline.even_parameters(part, ball_mm, shares))
                points.push_back(outline.ball_centre(t, ball_mm));
        }
        return points;
    }
    static std::vector<Vec2> at_share(const std::vector<Vec2>& section, double share) {
        const auto& [family, twist, wave, phase] = GetParam();
        const double angle = twist * share + wave * std::sin(2.0 * std::numbers::pi * share + phase);
        const Eigen::Rotation2Dd turn(angle);
        const Vec2 shift(6.0 * share * share, 4.0 * std::sin(3.0 * share));
        std::vector<Vec2> points;
        for (const Vec2& p : section)
            points.push_back(turn * p + shift);
        return points;
    }
};

TEST_P(UnevenTwist, SurfaceGoesThroughItsRows) {
    const std::vector<Vec2> points = section();
    std::vector<SurfaceRow> rows;
    std::optional<Vec2> le, te;
    std::vector<std::vector<Vec2>> measured;
    for (std::size_t k = 0; k < row_count; ++k) {
        const double z = 4.0 * static_cast<double>(k) + 0.8 * std::sin(2.6 * static_cast<double>(k));
        measured.push_back(at_share(points, z / 96.0));
        auto row = SurfaceRow::make(smooth_closed(measured.back()).value(), z, ball_mm, le, te);
        ASSERT_TRUE(row);
        le = row->le();
        te = row->te();
        rows.push_back(std::move(*row));
    }
    const auto fit = fit_surface(settle_rows(rows, 8));
    ASSERT_TRUE(fit);
    EXPECT_TRUE(fit->strays.empty());
    for (std::size_t k = 0; k < row_count; ++k) {
        std::vector<Vec2> level;
        for (const double u : span_parameters(fit->surface.u(), parts_of_a_span))
            level.push_back(fit->surface.position({u, rows[k].z_mm()}).head<2>());
        std::vector<ClosestPoint> feet(measured[k].size());
        ClosedCurve::through(level).value().closest(measured[k], feet);
        double largest = 0.0;
        for (const ClosestPoint& foot : feet)
            largest = std::max(largest, std::abs(foot.distance_mm));
        EXPECT_LT(largest, 0.6e-3) << "row " << k;
    }
}

using families::Family;
INSTANTIATE_TEST_SUITE_P(OfThreeFamilies, UnevenTwist,
                         testing::Values(Unevenness{Family::compressor, 0.5, 0.03, 0.0},
                                         Unevenness{Family::compressor, -0.6, 0.05, 2.0},
                                         Unevenness{Family::turbine, 0.4, 0.06, 0.5},
                                         Unevenness{Family::fan, 0.96, 0.08, 0.0}));

}  // namespace
}  // namespace cmm::fitting
