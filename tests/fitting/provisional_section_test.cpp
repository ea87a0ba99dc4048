// SPDX-License-Identifier: Apache-2.0
/// The section on top of a growing surface: what it is told to be before the one above it has closed, and how little
/// is left to change then.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "fitting/closed_curve.hpp"
#include "fitting/lean_of_nominal.hpp"
#include "fitting/surface_section.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr std::size_t grown_sections = 25, newest_kept = 16;

double largest_distance_mm(const std::vector<ContourPoint>& from, const std::vector<ContourPoint>& to) {
    std::vector<Vec2> places, line;
    for (const auto& p : from)
        places.push_back(p.position_mm);
    for (const auto& p : to)
        line.push_back(p.position_mm);
    const auto curve = ClosedCurve::through(line);
    EXPECT_TRUE(curve);
    std::vector<ClosestPoint> feet(places.size());
    curve->closest(places, feet);
    double largest = 0.0;
    for (const auto& foot : feet)
        largest = std::max(largest, std::abs(foot.distance_mm));
    return largest;
}

/// A blade measured from below, as PartJudge does it: the first two sections lean as the nominal.
struct GrowingBlade {
    struct Change {
        double from_flat_mm = 0.0, from_provisional_mm = 0.0;  // to final, the largest over all sections
        double provisional_mm = 0.0, outside = 0.0;            // off the truth, and share beyond U95
    };

    GrowingBlade(families::Family family, std::uint64_t seed, double sigma_mm) : blade(family, seed) {
        families::ScanOptions scanning;
        scanning.sigma_mm = sigma_mm;
        scanning.bad_share = sigma_mm > 0.0 ? 0.015 : 0.0;
        scanning.seed = seed;
        rows = families::scan_rows(blade, grown_sections, 2, blade.height() - 2, scanning);
        options.ball_radius_mm = 1.0;
    }

    /// `more_rad`: by which the nominal's walls lean more than the blade's; none: there is no nominal.
    Change grow(std::optional<double> more_rad) const {
        SurfaceCompensation surface(options.ball_radius_mm, newest_kept);
        Change change;
        std::vector<SectionFit> flat;
        std::optional<SectionFit> provisional;
        std::size_t points = 0;
        for (std::size_t k = 0; k < grown_sections; ++k) {
            flat.push_back(fit(k));
            EXPECT_TRUE(surface.add(flat[k].centres.curve, rows.heights[k], flat[k].le_point_mm, flat[k].te_point_mm));
            if (k > 0) {
                EXPECT_TRUE(surface.fit());
                const auto nominal = k < 2 ? nominal_at(k - 1, more_rad) : NominalNormal();
                const auto below = compensate_section(surface, rows.heights[k - 1], flat[k - 1], options, nominal);
                EXPECT_TRUE(below) << below.error().text();
                change.from_flat_mm =
                    std::max(change.from_flat_mm, largest_distance_mm(below->fit.contour, flat[k - 1].contour));
                if (provisional) {
                    change.from_provisional_mm = std::max(
                        change.from_provisional_mm, largest_distance_mm(below->fit.contour, provisional->contour));
                }
            }
            provisional = now(surface, k, flat[k], more_rad);
            if (!provisional) continue;
            const auto truth = blade.section(rows.heights[k]);
            for (const auto& p : provisional->contour) {
                const double off = std::abs(truth.closest(p.position_mm).distance);
                change.provisional_mm = std::max(change.provisional_mm, off);
                change.outside += off > p.u95_mm ? 1.0 : 0.0;
                ++points;
            }
        }
        change.outside /= double(points);
        return change;
    }

    SectionFit fit(std::size_t k) const {
        std::vector<Vec2> centres;
        for (const Vec3& p : rows.rows[k])
            centres.push_back(p.head<2>());
        SectionOptions hinted = options;
        hinted.le_hint = blade.outline(rows.heights[k]).le().nose;
        hinted.te_hint = blade.outline(rows.heights[k]).te().nose;
        auto fit = fit_section(centres, {}, hinted);
        EXPECT_TRUE(fit) << fit.error().text();
        return std::move(*fit);
    }

    NominalNormal nominal_at(std::size_t k, std::optional<double> more_rad) const {
        if (!more_rad) return {};
        const double z_mm = rows.heights[k];
        return [this, z_mm, more = *more_rad, section = blade.section(z_mm)](const Vec2& centre, const Vec2&) {
            const Vec3 normal = blade.at(section.closest(centre).t, z_mm).normal();
            const double lean = std::asin(normal.z()) + more;
            Vec3 leaning;
            leaning << std::cos(lean) * normal.head<2>().normalized(), std::sin(lean);
            return leaning;
        };
    }

    std::optional<SectionFit> now(const SurfaceCompensation& surface, std::size_t k, const SectionFit& flat,
                                  std::optional<double> more_rad) const {
        const auto nominal = k < 2 ? nominal_at(k, more_rad) : NominalNormal();
        if (k == 0 && !nominal) return std::nullopt;
        auto section = k > 0 ? compensate_section(surface, rows.heights[k], flat, options, nominal)
                             : compensate_by_nominal(flat, options, nominal);
        EXPECT_TRUE(section) << section.error().text();
        return std::move(section->fit);
    }

    families::TwistedBlade blade;
    families::BladeRows rows;
    SectionOptions options;
};

TEST(ProvisionalSection, HardlyChangesWhenTheOneAboveHasClosed) {
    for (const auto family : families::all_families)
        for (const bool nominal : {true, false}) {
            const GrowingBlade blade(family, 2, 1e-3);
            const auto change = blade.grow(nominal ? std::optional(0.0) : std::nullopt);
            SCOPED_TRACE(blade.blade.name() + (nominal ? " with its nominal" : ""));
            EXPECT_LT(change.from_provisional_mm, 2e-3);
            EXPECT_GT(change.from_flat_mm, 20.0 * change.from_provisional_mm);
            EXPECT_LT(change.provisional_mm, 2.5e-3);
            EXPECT_LT(change.outside, 0.05);
        }
}

TEST(ProvisionalSection, WithoutNoiseIsNearTheTruth) {
    for (const auto family : families::all_families) {
        const auto change = GrowingBlade(family, 2, 0.0).grow(0.0);
        EXPECT_LT(change.provisional_mm, 1e-3) << to_string(family) << ": the first tells no bend";
        EXPECT_LT(change.outside, 0.01) << to_string(family);
    }
}

/// Nobody knows yet that the part leans otherwise: the first two sections are off, and U95 says so.
TEST(ProvisionalSection, OfAPartThatLeansOtherwiseThanItsNominalTheUncertaintySaysSo) {
    for (const auto family : families::all_families) {
        const GrowingBlade blade(family, 2, 1e-3);
        SCOPED_TRACE(blade.blade.name());
        const auto change = blade.grow(0.03);
        EXPECT_GT(change.provisional_mm, 4e-3);
        EXPECT_LT(change.outside, 0.05);
    }
}

}  // namespace
}  // namespace cmm::fitting
