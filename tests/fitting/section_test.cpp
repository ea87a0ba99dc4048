// SPDX-License-Identifier: Apache-2.0
#include "fitting/section.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>
#include <numbers>
#include <utility>

#include "core/rng.hpp"
#include "fitting/vec2.hpp"
#include "support/families.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

truth::Scan blade_scan(truth::ScanOptions options = {}, double ball = 1.0) {
    return truth::scan(truth::ball_centres(truth::envelope_blade({}), ball), options);
}

SectionFit fit_or_fail(const std::vector<Vec2>& points, const SectionOptions& options = {}) {
    auto fit = fit_section(points, {}, options);
    EXPECT_TRUE(fit) << (fit ? "" : fit.error().message);
    return fit ? std::move(*fit) : SectionFit{};
}

TEST(Section, ReportsWhatTheBladeIs) {
    const auto fit = fit_or_fail(blade_scan().points);
    ASSERT_EQ(fit.contour.size(), 2400U);
    EXPECT_TRUE(fit.missing.empty()) << fit.missing;
    EXPECT_NEAR(fit.noise_sigma_mm, 0.001, 0.0004);
    ASSERT_TRUE(fit.le.valid && fit.te.valid) << fit.le.why << fit.te.why;
    EXPECT_NEAR(fit.le.radius_mm, 0.6, 3.0 * fit.le.radius_u95_mm);
    EXPECT_NEAR(fit.te.radius_mm, 0.3, 3.0 * fit.te.radius_u95_mm);
    EXPECT_LT(fit.le.radius_u95_mm, 0.01);
    // 39.1 mm between the camber line's ends, extended by the radii at half the camber angle
    EXPECT_NEAR(fit.chord_mm, 39.1 + 0.9 * std::cos(15.0 * std::numbers::pi / 180.0), 0.02);
    double area = 0.0;
    for (std::size_t i = 0; i < fit.contour.size(); ++i) {
        const ContourPoint &a = fit.contour[i], &b = fit.contour[(i + 1) % fit.contour.size()];
        area += 0.5 * (a.position_mm.x() * b.position_mm.y() - a.position_mm.y() * b.position_mm.x());
        EXPECT_NEAR(a.normal.norm(), 1.0, 1e-12);
        EXPECT_GT(a.u95_mm, 0.0);
        EXPECT_LT(a.u95_mm, 0.003);
        if (i > 0) {
            EXPECT_GT(a.arc_length_mm, fit.contour[i - 1].arc_length_mm);
        }
    }
    EXPECT_GT(area, 0.0) << "counter-clockwise";
    EXPECT_LT((fit.contour[0].position_mm - fit.le_point_mm).norm(), 0.01) << "begins at the LE nose";
}

TEST(Section, LeanIsPartOfTheUncertainty) {
    SectionOptions options;
    options.lean_rad = 10.0 * std::numbers::pi / 180.0;
    const auto points = blade_scan().points;
    const auto plain = fit_or_fail(points), leaning = fit_or_fail(points, options);
    // seed 000, eq 18: 15.4 um per millimetre of ball at 10 degrees
    EXPECT_NEAR(leaning.contour[100].u95_mm - plain.contour[100].u95_mm, 0.0154, 0.0001);
}

/// Rigid motion: to 1 nm of rounding. Start and direction: the same points give the same result.
TEST(Section, IsInvariantUnderMotionStartAndDirection) {
    auto points = blade_scan().points;
    const auto reference = fit_or_fail(points);
    const Eigen::Rotation2Dd turn(1.1);
    std::vector<Vec2> moved;
    for (const Vec2& p : points)
        moved.push_back(turn * p + Vec2(300, -200));
    const auto after = fit_or_fail(moved);
    std::reverse(points.begin(), points.end());
    const auto reversed = fit_or_fail(points);
    std::rotate(points.begin(), points.begin() + 77, points.end());
    const auto rotated = fit_or_fail(points);
    ASSERT_EQ(after.contour.size(), reference.contour.size());
    for (std::size_t i = 0; i < reference.contour.size(); ++i) {
        const Vec2& p = reference.contour[i].position_mm;
        EXPECT_LT((after.contour[i].position_mm - (turn * p + Vec2(300, -200))).norm(), 1e-6);
        EXPECT_LT((reversed.contour[i].position_mm - p).norm(), 1e-6);
        EXPECT_LT((rotated.contour[i].position_mm - p).norm(), 1e-6);
        EXPECT_EQ(after.contour[i].zone, reference.contour[i].zone);
    }
}

TEST(Section, EveryPointHasItsVerdict) {
    auto scan = blade_scan();
    std::vector<RejectReason> excluded(scan.points.size(), RejectReason::none);
    excluded[10] = RejectReason::by_operator;
    excluded[11] = RejectReason::no_contact;
    scan.points[20] = {std::numeric_limits<double>::quiet_NaN(), 0.0};
    scan.points[31] = scan.points[30];
    const auto fit = fit_section(scan.points, excluded, {});
    ASSERT_TRUE(fit) << fit.error().message;
    ASSERT_EQ(fit->verdicts.size(), scan.points.size());
    EXPECT_EQ(fit->verdicts[10].reason, RejectReason::by_operator);
    EXPECT_EQ(fit->verdicts[11].reason, RejectReason::no_contact);
    EXPECT_EQ(fit->verdicts[20].reason, RejectReason::no_contact);
    EXPECT_EQ(fit->verdicts[31].reason, RejectReason::duplicate);
    std::size_t rejected = 0;
    for (const auto& verdict : fit->verdicts)
        rejected += verdict.reason != RejectReason::none;
    EXPECT_EQ(fit->rejected, rejected);
}

/// An operator rejects a good point and restores a bad one: the fit follows, and says whose word it was.
TEST(Section, AnOperatorHasTheLastWord) {
    const auto scan = blade_scan();
    const auto plain = fit_or_fail(scan.points);
    std::vector<RejectReason> excluded(scan.points.size(), RejectReason::none);
    std::vector<char> kept(scan.points.size(), 0);
    std::size_t bad = scan.points.size(), good = scan.points.size();
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
        const bool rejected = plain.verdicts[i].reason == RejectReason::spline_residual;
        if (rejected && std::abs(scan.bad[i]) > 0.05 && bad == scan.points.size()) bad = i;
        if (!rejected && scan.bad[i] == 0.0) good = i;
    }
    ASSERT_LT(bad, scan.points.size());
    ASSERT_LT(good, scan.points.size());
    excluded[good] = RejectReason::by_operator;
    kept[bad] = 1;
    const auto fit = fit_section(scan.points, excluded, {}, kept);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_EQ(fit->verdicts[good].reason, RejectReason::by_operator);
    EXPECT_EQ(fit->verdicts[bad].reason, RejectReason::none);
    EXPECT_TRUE(fit->verdicts[bad].kept);
    EXPECT_FALSE(fit->verdicts[good].kept);
    EXPECT_NEAR(plain.verdicts[bad].residual_mm, scan.bad[bad], 0.005);
    EXPECT_LT(std::abs(fit->verdicts[bad].residual_mm), 0.2 * std::abs(scan.bad[bad])) << "the curve follows";
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
        if (i == bad || i == good) continue;
        EXPECT_EQ(fit->verdicts[i].reason == RejectReason::none, plain.verdicts[i].reason == RejectReason::none)
            << i << ": nothing else changes";
    }
}

/// Of a run of three bad points beside the end of an edge the middle one continued the edge, and alone it turned the
/// curve to itself.
TEST(Section, TheMiddleOfARunIsNoWitnessForItself) {
    for (const auto& [family, seed] :
         {std::pair{families::Family::turbine, 130U}, std::pair{families::Family::fan, 54U}}) {
        const auto blade = families::make(family, 40000 + seed);
        families::ScanOptions scanning;
        scanning.seed = 70000 + seed;
        const auto scan = families::scan(blade, scanning);
        SectionOptions options;
        options.le_hint = blade.le().nose;
        options.te_hint = blade.te().nose;
        const auto fit = fit_or_fail(scan.points, options);
        for (std::size_t i = 0; i < scan.points.size(); ++i)
            if (std::abs(scan.bad[i]) >= scanning.bad_low_mm) {
                EXPECT_NE(fit.verdicts[i].reason, RejectReason::none) << families::to_string(family) << " " << i;
            }
    }
}

TEST(Section, PointsOnThePartNeedNoBall) {
    truth::ScanOptions scanning;
    scanning.noise = 0.0;
    scanning.bad_share = 0.0;
    SectionOptions options;
    options.ball_radius_mm = 0.0;
    const auto part = truth::envelope_blade({});
    const auto fit = fit_or_fail(truth::scan(part, scanning).points, options);
    for (std::size_t i = 0; i < fit.contour.size(); i += 7)
        EXPECT_LT(std::abs(part.distance(fit.contour[i].position_mm)), 0.006);
}

TEST(Section, RefusesWithReasons) {
    const auto expect_error = [](const std::vector<Vec2>& points, const std::string& word) {
        const auto fit = fit_section(points, {}, {});
        ASSERT_FALSE(fit);
        EXPECT_EQ(fit.error().code, core::ErrorCode::fit_not_evaluable);
        EXPECT_NE(fit.error().message.find(word), std::string::npos) << fit.error().message;
    };
    expect_error({}, "16");
    expect_error({{0, 0}, {1, 1}}, "16");
    expect_error(std::vector<Vec2>(100, Vec2(3, 4)), "16");
    truth::ScanOptions open;
    open.overlap_mm = -10.0;
    expect_error(blade_scan(open).points, "open");
    std::vector<Vec2> round;
    for (int i = 0; i < 200; ++i)
        round.emplace_back(9 * std::cos(i * std::numbers::pi / 100), 9 * std::sin(i * std::numbers::pi / 100));
    expect_error(round, "edges");
    SectionOptions bad;
    bad.ball_radius_mm = -1.0;
    EXPECT_FALSE(fit_section(blade_scan().points, {}, bad));
}

TEST(Section, SurvivesGarbage) {
    core::Rng rng(99);
    for (int run = 0; run < 300; ++run) {
        const std::size_t n = 10 + rng.below(400);
        std::vector<Vec2> points;
        for (std::size_t i = 0; i < n; ++i) {
            switch (run % 5) {
                case 0:
                    points.emplace_back(rng.uniform(-5, 5), rng.uniform(-5, 5));
                    break;
                case 1:
                    points.emplace_back(rng.uniform(-5, 5), 1e-9 * rng.normal());
                    break;
                case 2:
                    points.emplace_back(rng.below(3) ? rng.normal() : std::nan(""), rng.normal());
                    break;
                case 3:
                    points.emplace_back(static_cast<double>(rng.below(3)), static_cast<double>(rng.below(3)));
                    break;
                default:
                    points.emplace_back(1e8 * rng.normal(),
                                        std::numeric_limits<double>::infinity() * (rng.below(9) == 0 ? 1.0 : 0.0));
                    break;
            }
        }
        const auto fit = fit_section(points, {}, {});
        if (fit) {
            EXPECT_EQ(fit->verdicts.size(), n);
        }
    }
}

}  // namespace
}  // namespace cmm::fitting
