// SPDX-License-Identifier: Apache-2.0
/// Compensation by the surface of ball centres against exact truth: three families, 25 sections, noise, bad points.
#include "fitting/compensation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>

#include "fitting/centre_curve.hpp"
#include "fitting/offset.hpp"
#include "support/contour_change.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

constexpr double ball_mm = 1.0;

std::vector<Vec2> flat(const std::vector<Vec3>& row) {
    std::vector<Vec2> points;
    for (const Vec3& p : row)
        points.push_back(p.head<2>());
    return points;
}

struct Errors {
    double squares = 0.0, largest = 0.0;
    std::size_t count = 0;
    void add(double error) {
        squares += error * error;
        largest = std::max(largest, std::abs(error));
        ++count;
    }
    double rms_um() const { return 1e3 * std::sqrt(squares / double(std::max<std::size_t>(1, count))); }
    double largest_um() const { return 1e3 * largest; }
};

struct Tally3 {
    Errors side, edge, flat_offset;
    void add(const families::TwistedBlade::Section& truth, const Vec2& p) {
        const families::Foot foot = truth.closest(p);
        const auto part = families::Blade::part_of(foot.t);
        (part == families::Part::le || part == families::Part::te ? edge : side).add(foot.distance);
    }
    void print(const std::string& what) const {
        std::cout << what << ": sides rms " << side.rms_um() << " max " << side.largest_um() << ", edges rms "
                  << edge.rms_um() << " max " << edge.largest_um() << " um; 2-D offset max " << flat_offset.largest_um()
                  << " um\n";
    }
};

SectionOptions hints(const families::TwistedBlade& blade, double z) {
    const families::Blade outline = blade.outline(z);
    SectionOptions options;
    options.ball_radius_mm = ball_mm;
    options.le_hint = outline.le().nose;
    options.te_hint = outline.te().nose;
    return options;
}

/// By every `step`th section.
Tally3 judge(const families::TwistedBlade& blade, const families::ScanOptions& scanning, std::size_t step = 3) {
    const auto rows = families::scan_rows(blade, 25, 2, blade.height() - 2, scanning);
    SurfaceCompensation compensation(ball_mm);
    for (std::size_t k = 0; k < rows.rows.size(); ++k) {
        const auto status = compensation.add(flat(rows.rows[k]), rows.heights[k], hints(blade, rows.heights[k]));
        EXPECT_TRUE(status) << blade.name() << " " << k << ": " << status.error().message;
    }
    EXPECT_TRUE(compensation.fit());
    Tally3 tally;
    for (std::size_t k = 0; k < rows.rows.size(); k += step) {
        const auto truth = blade.section(rows.heights[k]);
        const auto contour = compensation.contour(rows.heights[k]);
        EXPECT_TRUE(contour) << blade.name() << ": " << contour.error().message;
        if (!contour) continue;
        EXPECT_EQ(contour->final, k + 1 < rows.rows.size());
        for (std::size_t i = 0; i < contour->points.size(); i += 5)
            tally.add(truth, contour->points[i].position_mm.head<2>());
        for (const auto& p : offset_inwards(compensation.rows()[k].smooth().curve, ball_mm, 300).points)
            tally.flat_offset.add(truth.closest(p.position).distance);
    }
    return tally;
}

/// Wanted are 0.25 and 0.60 um rms, 1.5 and 3.0 um at most.
void expect_contours_as_wanted(families::Family family, std::uint64_t seed) {
    const families::TwistedBlade blade(family, seed);
    families::ScanOptions scanning;
    scanning.seed = seed;
    const Tally3 tally = judge(blade, scanning);
    tally.print(blade.name());
    EXPECT_LT(tally.side.rms_um(), 0.25) << blade.name();
    EXPECT_LT(tally.edge.rms_um(), 0.40) << blade.name();
    EXPECT_LT(tally.side.largest_um(), 1.5) << blade.name();
    EXPECT_LT(tally.edge.largest_um(), 3.0) << blade.name();
    EXPECT_GT(tally.flat_offset.largest_um(), 5.0) << "a plain 2-D offset is far worse";
}

TEST(Compensation, ContoursOfTwistedBlades) {
    for (const auto family : families::all_families)
        for (const std::uint64_t seed : {1, 3})
            expect_contours_as_wanted(family, seed);
}

/// Edges of fans whose curvature steps by 0.25 to 0.4 /mm, which 6 to 15 of 25 rows tell: without joints these contours
/// were 1.9 to 2.9 um off beside them.
TEST(Compensation, WeakJointsAreThoseOfAllRows) {
    for (const std::uint64_t seed : {22, 35, 43})
        expect_contours_as_wanted(families::Family::fan, seed);
}

/// At 5 um a run of bad points at a thin TE may pass for the part. Rows that follow it fold what is offset from them:
/// loops of a tenth to half a millimetre.
TEST(Compensation, BadPointsInMuchNoiseMakeNoLoops) {
    const families::TwistedBlade blade(families::Family::turbine, 4);
    families::ScanOptions scanning;
    scanning.sigma_mm = 5e-3;
    scanning.seed = 1;
    const Tally3 tally = judge(blade, scanning, 1);
    tally.print(blade.name() + " at 5 um");
    EXPECT_LT(tally.side.rms_um(), 0.8);
    EXPECT_LT(tally.side.largest_um(), 7.5);
    EXPECT_LT(tally.edge.largest_um(), 10.0);
}

TEST(Compensation, ContoursWithoutNoise) {
    families::ScanOptions scanning;
    scanning.sigma_mm = 0.0;
    scanning.bad_share = 0.0;
    // The last had 0.08 um beside its TE, where its rows' noses were those of the nearest of their contours' points.
    for (const auto& [family, seed] : {std::pair{families::Family::compressor, 1},
                                       {families::Family::turbine, 1},
                                       {families::Family::fan, 1},
                                       {families::Family::turbine, 3}}) {
        const families::TwistedBlade blade(family, seed);
        const Tally3 tally = judge(blade, scanning);
        tally.print(blade.name() + " without noise");
        EXPECT_LT(tally.side.rms_um(), 0.01) << blade.name();
        EXPECT_LT(tally.edge.rms_um(), 0.01) << blade.name();
        EXPECT_LT(tally.side.largest_um(), 0.05) << blade.name();
        EXPECT_LT(tally.edge.largest_um(), 0.05) << blade.name();
    }
}

/// Dirt on one section, 40 um high over ten points, that its own points do not betray.
TEST(Compensation, ASectionThatLiesApartDoesNotMoveItsNeighbours) {
    const families::TwistedBlade blade(families::Family::compressor, 2);
    auto rows = families::scan_rows(blade, 13, 2, blade.height() - 2, {});
    constexpr std::size_t dirty = 6;
    const auto truth = blade.section(rows.heights[dirty]);
    const Vec2 at = blade.outline(rows.heights[dirty]).at(3.5).position;
    for (Vec3& p : rows.rows[dirty]) {
        const double away = (p.head<2>() - at).norm() / 4.0;
        if (away > 1.5) continue;
        const families::Foot foot = truth.closest(p.head<2>());
        const Vec3 out = blade.at(foot.t, rows.heights[dirty]).normal();
        p.head<2>() += 0.040 * std::exp(-away * away) * out.head<2>().normalized();
    }
    SurfaceCompensation compensation(ball_mm);
    for (std::size_t k = 0; k < rows.rows.size(); ++k)
        ASSERT_TRUE(compensation.add(flat(rows.rows[k]), rows.heights[k], hints(blade, rows.heights[k])));
    ASSERT_TRUE(compensation.fit());
    for (const std::size_t k : {dirty - 1, dirty + 1}) {
        Tally3 tally;
        const auto section = blade.section(rows.heights[k]);
        const ContactContour contour = compensation.contour(rows.heights[k]).value();
        for (const ContactPoint& p : contour.points)
            tally.add(section, p.position_mm.head<2>());
        tally.print("beside dirt");
        EXPECT_LT(tally.side.rms_um(), 0.25) << "1.6 where the neighbours follow the dirt";
        EXPECT_LT(tally.side.largest_um(), 1.0) << "6.5";
    }
}

TEST(Compensation, NormalsLeanAndPlanesAreMet) {
    const families::TwistedBlade blade(families::Family::turbine, 2);
    families::ScanOptions scanning;
    scanning.sigma_mm = 0.0;
    scanning.bad_share = 0.0;
    const auto rows = families::scan_rows(blade, 12, 2, blade.height() - 2, scanning);
    SurfaceCompensation compensation(ball_mm);
    for (std::size_t k = 0; k < rows.rows.size(); ++k)
        ASSERT_TRUE(compensation.add(flat(rows.rows[k]), rows.heights[k], hints(blade, rows.heights[k])));
    ASSERT_TRUE(compensation.fit());
    const double z = 0.47 * blade.height();
    const auto contour = compensation.contour(z, 500);
    ASSERT_TRUE(contour);
    const auto truth = blade.section(z);
    double steepest = 0.0;
    for (const ContactPoint& p : contour->points) {
        EXPECT_NEAR(p.position_mm.z(), z, 1e-9);
        const Vec3 normal = blade.at(truth.closest(p.position_mm.head<2>()).t, z).normal();
        EXPECT_GT(p.normal.dot(normal), std::cos(0.02));
        EXPECT_NEAR(p.lean_rad, std::asin(normal.z()), 0.02);
        steepest = std::max(steepest, std::abs(p.lean_rad));
    }
    EXPECT_GT(steepest, 0.05);
}

TEST(Compensation, ASectionIsProvisionalUntilTheNextHasClosed) {
    const families::TwistedBlade blade(families::Family::compressor, 2);
    const auto rows = families::scan_rows(blade, 8, 10, 40, {});
    SurfaceCompensation compensation(ball_mm);
    EXPECT_FALSE(compensation.contour(10)) << "nothing there yet";
    for (std::size_t k = 0; k < rows.rows.size(); ++k) {
        const auto provisional = k > 4 ? compensation.contour(rows.heights[k - 1]) : ContactContour();
        ASSERT_TRUE(provisional);
        ASSERT_TRUE(compensation.add(flat(rows.rows[k]), rows.heights[k], hints(blade, rows.heights[k])));
        EXPECT_FALSE(compensation.contour(rows.heights[k])) << "the surface is not yet laid";
        EXPECT_EQ(compensation.fit().has_value(), k > 0);
        if (k <= 4) continue;
        EXPECT_FALSE(provisional->final);
        const auto below = compensation.contour(rows.heights[k - 1]);
        ASSERT_TRUE(below);
        EXPECT_TRUE(below->final);
        const double change_mm = families::contour_change_mm(*provisional, *below);
        EXPECT_GT(change_mm, 0.0);
        EXPECT_LT(change_mm, 0.020);
    }
    EXPECT_FALSE(compensation.contour(9.0));
    EXPECT_FALSE(compensation.contour(41.0));
    EXPECT_FALSE(compensation.contour(std::nan("")));
}

TEST(Compensation, AGrowingSurfaceIsThatOfTheNewestSections) {
    const families::TwistedBlade blade(families::Family::compressor, 2);
    const auto rows = families::scan_rows(blade, 8, 10, 40, {});
    SurfaceCompensation all(ball_mm), newest(ball_mm, 4), last(ball_mm, 4);
    for (std::size_t k = 0; k < rows.rows.size(); ++k)
        for (SurfaceCompensation* surface : {&all, &newest, &last}) {
            if (surface == &last && k < 4) continue;
            ASSERT_TRUE(surface->add(flat(rows.rows[k]), rows.heights[k], hints(blade, rows.heights[k])));
        }
    for (SurfaceCompensation* surface : {&all, &newest, &last})
        ASSERT_TRUE(surface->fit());
    EXPECT_EQ(all.rows().size(), 8U);
    ASSERT_EQ(newest.rows().size(), 4U);
    EXPECT_EQ(newest.rows()[0].z_mm(), rows.heights[4]);
    EXPECT_FALSE(newest.contour(rows.heights[3]));
    const double z = rows.heights[6];
    EXPECT_LT(families::contour_change_mm(*newest.contour(z), *last.contour(z)), 1e-4);
    EXPECT_LT(families::contour_change_mm(*newest.contour(z), *all.contour(z)), 0.003);
}

TEST(Compensation, DegenerateInputHasAName) {
    const families::TwistedBlade blade(families::Family::compressor, 3);
    const auto rows = families::scan_rows(blade, 3, 10, 20, {});
    const auto options = hints(blade, 10);
    SurfaceCompensation compensation(ball_mm);
    EXPECT_FALSE(compensation.add(std::vector<Vec2>{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0.5}}, 10, options));
    EXPECT_FALSE(compensation.add(std::vector<Vec2>{}, 10, options));
    EXPECT_FALSE(compensation.add(std::vector<Vec2>(50, Vec2(std::nan(""), 0)), 10, options));
    EXPECT_FALSE(compensation.add(flat(rows.rows[0]), std::nan(""), options));
    EXPECT_EQ(compensation.rows().size(), 0U) << "a refused section leaves nothing behind";
    ASSERT_TRUE(compensation.add(flat(rows.rows[0]), 10, options));
    EXPECT_FALSE(compensation.add(flat(rows.rows[0]), 10, options)) << "the same again";
    EXPECT_FALSE(compensation.add(flat(rows.rows[1]), 5, options)) << "below";
    std::vector<Vec2> elsewhere = flat(rows.rows[1]);
    for (Vec2& p : elsewhere)
        p += Vec2(500, 0);
    EXPECT_FALSE(compensation.add(elsewhere, 15, options)) << "another part";
    ASSERT_TRUE(compensation.add(flat(rows.rows[1]), rows.heights[1], options));
    ASSERT_TRUE(compensation.fit());
    const auto between = compensation.contour(12.0);
    ASSERT_TRUE(between) << between.error().message;
    const auto truth = blade.section(12.0);
    for (const ContactPoint& p : between->points)
        EXPECT_LT(std::abs(truth.closest(p.position_mm.head<2>()).distance), 0.2) << "two sections: straight lines";
    EXPECT_EQ(compensation.rows().size(), 2U);
    EXPECT_FALSE(SurfaceCompensation(std::nan("")).add(flat(rows.rows[0]), 10, options));
}

TEST(Compensation, HugeAndTinyParts) {
    for (const double scale : {0.1, 50.0}) {
        const families::TwistedBlade blade(families::Family::turbine, 4);
        auto rows = families::scan_rows(blade, 6, 10, 40, {});
        SurfaceCompensation compensation(scale * ball_mm);
        for (std::size_t k = 0; k < rows.rows.size(); ++k) {
            auto points = flat(rows.rows[k]);
            for (Vec2& p : points)
                p *= scale;
            SectionOptions options;
            options.ball_radius_mm = scale;
            options.le_hint = scale * *hints(blade, rows.heights[k]).le_hint;
            options.te_hint = scale * *hints(blade, rows.heights[k]).te_hint;
            const auto status = compensation.add(points, scale * rows.heights[k], options);
            ASSERT_TRUE(status) << scale << ": " << status.error().message;
        }
        ASSERT_TRUE(compensation.fit());
        const auto contour = compensation.contour(scale * 25.0);
        ASSERT_TRUE(contour) << contour.error().message;
        const auto truth = blade.section(25.0);
        for (const ContactPoint& p : contour->points)
            EXPECT_LT(std::abs(truth.closest(p.position_mm.head<2>() / scale).distance), 0.05) << scale;
    }
}

}  // namespace
}  // namespace cmm::fitting
