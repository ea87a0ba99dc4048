// SPDX-License-Identifier: Apache-2.0
/// Stretches that nobody measured: found wherever the scan begins, bridged for the curve's sake, never shown as
/// measured.
#include "fitting/gaps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "fitting/nominal.hpp"
#include "fitting/section.hpp"
#include "support/families.hpp"

namespace cmm::fitting {
namespace {

/// A scan of a blade without the points that `missing` names by their parameter on the outline.
struct PartialScan {
    families::Blade blade;
    std::vector<Vec2> points;
    std::vector<double> bad;  ///< displacement of each along the normal, mm
    SectionOptions options;

    PartialScan(families::Family family, const std::function<bool(double)>& missing, double sigma_mm = 1e-3,
                std::uint64_t seed = 1, std::uint64_t blade_seed = 3)
        : blade(families::make(family, blade_seed)) {
        families::ScanOptions scanning;
        scanning.sigma_mm = sigma_mm;
        scanning.bad_share = sigma_mm > 0.0 ? 0.015 : 0.0;
        scanning.seed = seed;
        const auto scan = families::scan(blade, scanning);
        for (std::size_t i = 0; i < scan.points.size(); ++i) {
            if (missing(scan.t[i])) continue;
            points.push_back(scan.points[i]);
            bad.push_back(scan.bad[i]);
        }
        options.le_hint = blade.le().nose;
        options.te_hint = blade.te().nose;
    }
    SectionFit fit() const {
        auto fit = fit_section(points, {}, options);
        EXPECT_TRUE(fit) << fit.error().text();
        return fit ? std::move(*fit) : SectionFit{};
    }
};

bool nothing(double) {
    return false;
}
/// Two fifths of the way along the suction side, a tenth of it long.
bool on_suction_side(double t) {
    return t > 3.4 && t < 3.5;
}
/// Parts are LE, pressure side, TE, suction side: all of the TE and an eighth of either side.
bool round_the_te(double t) {
    return t > 1.875 && t < 3.125;
}

/// The blade itself, or one that differs from it by up to 1.8 `off_mm`.
NominalSection nominal_of(const families::Blade& blade, double off_mm = 0.0) {
    constexpr int places = 1200;
    std::vector<Vec2> points;
    std::vector<double> way(1, 0.0);
    for (int i = 0; i <= places; ++i) {
        points.push_back(blade.at(4.0 * (i % places) / places).position);
        if (i > 0) way.push_back(way.back() + (points[i] - points[i - 1]).norm());
    }
    points.pop_back();
    for (int i = 0; i < places; ++i)
        points[i] += off_mm * (1.0 + 0.8 * std::sin(4.0 * std::numbers::pi * way[i] / way.back())) *
                     blade.at(4.0 * i / places).normal();
    return analyse_nominal(points, {blade.le().nose, blade.te().nose}).value();
}

double unmeasured_share(const SectionFit& fit) {
    const auto count = std::count_if(fit.contour.begin(), fit.contour.end(), [](const auto& p) { return !p.measured; });
    return static_cast<double>(count) / static_cast<double>(fit.contour.size());
}

/// Of what is shown as measured, mm.
double largest_error(const families::Blade& blade, const SectionFit& fit) {
    double largest = 0.0;
    for (const auto& p : fit.contour)
        if (p.measured) largest = std::max(largest, std::abs(blade.distance(p.position_mm)));
    return largest;
}

TEST(Gaps, AScanAllRoundHasNone) {
    for (const auto family : families::all_families)
        for (std::uint64_t seed = 1; seed <= 40; ++seed)
            EXPECT_EQ(unmeasured_share(PartialScan(family, nothing, 1e-3, seed).fit()), 0.0)
                << families::to_string(family) << " " << seed;
}

TEST(Gaps, WhatIsMissingIsNotMeasuredAndTheRestIsAsGood) {
    for (const auto family : families::all_families) {
        SCOPED_TRACE(families::to_string(family));
        const PartialScan partial(family, on_suction_side);
        const auto fit = partial.fit();
        for (const auto& p : fit.contour) {
            const double t = partial.blade.closest(p.position_mm).t;
            const bool inside = t > 3.405 && t < 3.495, away = t < 3.36 || t > 3.54;  // four points on either side
            EXPECT_FALSE(inside && p.measured) << t;
            EXPECT_FALSE(away && !p.measured) << t;
        }
        EXPECT_LT(largest_error(partial.blade, fit), 4e-3);
    }
}

/// The gap is one wherever the scan begins, also where it begins behind the gap and ends before it.
TEST(Gaps, ItDoesNotMatterWhereTheScanBegins) {
    PartialScan partial(families::Family::turbine, on_suction_side);
    const auto reference = partial.fit();
    for (const std::size_t turned : {1U, 100U, 250U, 400U}) {
        auto& points = partial.points;
        std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(turned), points.end());
        const auto fit = partial.fit();
        ASSERT_EQ(fit.contour.size(), reference.contour.size());
        for (std::size_t i = 0; i < fit.contour.size(); ++i) {
            EXPECT_LT((fit.contour[i].position_mm - reference.contour[i].position_mm).norm(), 1e-9);
            EXPECT_EQ(fit.contour[i].measured, reference.contour[i].measured);
        }
    }
}

const std::function<bool(double)> edges_missing[] = {round_the_te, [](double t) { return t > 2.0 && t < 3.0; },
                                                     [](double t) { return t < 1.0; }};

/// Nothing tells which edge it is, wherever the scan begins, and however sparse the sides beside it are.
TEST(Gaps, WithoutNominalAndHintsAMissingEdgeLeavesTheSectionOpen) {
    for (const auto family : families::all_families)
        for (const auto& missing : edges_missing) {
            SCOPED_TRACE(families::to_string(family));
            PartialScan partial(family, missing);
            partial.options.le_hint.reset();
            partial.options.te_hint.reset();
            for (int turned = 0; turned < 3; ++turned) {
                const auto fit = fit_section(partial.points, {}, partial.options);
                ASSERT_FALSE(fit);
                EXPECT_EQ(fit.error().code, core::ErrorCode::fit_not_evaluable);
                EXPECT_NE(fit.error().message.find("open, nothing was measured between"), std::string::npos)
                    << fit.error().message;
                std::rotate(partial.points.begin(), partial.points.begin() + 151, partial.points.end());
            }
        }
}

/// Where a few points are all there is of an edge and some of those are bad, the edge is as good as not measured; who
/// looks for the points finds them in the report.
TEST(Gaps, BadPointsOfAnEdgeThatHasNoOthersAreCounted) {
    for (const auto family : families::all_families) {
        SCOPED_TRACE(families::to_string(family));
        int place = 0;
        PartialScan partial(
            family, [place](double t) mutable { return t > 2.0 && t < 3.0 && ++place % 9 != 0; }, 0.0);
        partial.options.le_hint.reset();
        partial.options.te_hint.reset();
        std::size_t bad = 0;
        for (Vec2& point : partial.points) {
            const double t = partial.blade.closest(point).t;
            if (std::abs(t - 2.5) > 0.2) continue;
            point += (++bad % 2 == 0 ? 0.1 : 0.4) * partial.blade.at(t).normal();
        }
        const auto fit = fit_section(partial.points, {}, partial.options);
        ASSERT_FALSE(fit);
        EXPECT_NE(fit.error().message.find(" mm but bad points ("), std::string::npos) << fit.error().message;
    }
}

/// With a nominal, or hints that say which edge it is, the rest is as good as ever, and nothing is said of the edge.
TEST(Gaps, AnEdgeMayBeMissing) {
    for (const auto family : families::all_families)
        for (const auto& missing : {edges_missing[1], edges_missing[2]})
            for (const bool with_nominal : {false, true}) {
                SCOPED_TRACE(families::to_string(family) + (with_nominal ? ", nominal" : ", hints"));
                PartialScan partial(family, missing);
                const auto nominal = nominal_of(partial.blade);
                if (with_nominal) partial.options.nominal = &nominal.curve();
                const auto fit = partial.fit();
                EXPECT_NE(fit.missing.find("nothing was measured between"), std::string::npos) << fit.missing;
                EXPECT_LT(largest_error(partial.blade, fit), 6e-3);
                const bool le = missing(0.5);
                EXPECT_FALSE((le ? fit.le : fit.te).valid);
                EXPECT_TRUE((le ? fit.te : fit.le).valid) << (le ? fit.te : fit.le).why;
                for (const auto& p : fit.contour) {
                    const double t = partial.blade.closest(p.position_mm).t;
                    EXPECT_FALSE(p.measured && missing(t)) << t;
                }
            }
}

struct SideCase {
    std::string name;
    std::function<bool(double)> missing;
};

/// Wherever the scan begins, in whichever direction it goes, and however the part lies to its nominal and differs from
/// it.
TEST(Gaps, ASideMayBeMissingWhereANominalTellsTheWay) {
    const SideCase cases[] = {{"pressure side alone", [](double t) { return t < 1.0 || t > 2.0; }},
                              {"suction side alone", [](double t) { return t < 3.0; }},
                              {"no suction side", [](double t) { return t > 3.0; }},
                              {"no pressure side", [](double t) { return t > 1.0 && t < 2.0; }},
                              {"half of the suction side alone", [](double t) { return t < 3.3 || t > 3.7; }},
                              {"no edges", [](double t) { return t < 1.0 || (t > 2.0 && t < 3.0); }}};
    for (const auto family : families::all_families)
        for (const auto& one : cases)
            for (const double off_mm : {0.0, 0.1}) {
                PartialScan partial(family, one.missing);
                const auto nominal = nominal_of(partial.blade, off_mm);
                partial.options.nominal = &nominal.curve();
                const PlaneMotion laid{Vec2::Zero(), Vec2(0.8, -0.4), 0.02};
                for (Vec2& p : partial.points)
                    p = laid.apply(p);
                auto& points = partial.points;
                std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(points.size() / 3),
                            points.end());
                for (const bool backwards : {false, true}) {
                    SCOPED_TRACE(families::to_string(family) + ", " + one.name + (backwards ? ", backwards" : ""));
                    if (backwards) std::reverse(points.begin(), points.end());
                    auto fit = partial.fit();
                    EXPECT_FALSE(fit.missing.empty());
                    std::size_t within = 0, measured = 0;
                    for (auto& p : fit.contour) {
                        p.position_mm = laid.undo(p.position_mm);
                        measured += p.measured ? 1 : 0;
                        within += p.measured && std::abs(partial.blade.distance(p.position_mm)) < p.u95_mm ? 1 : 0;
                    }
                    EXPECT_LT(largest_error(partial.blade, fit), 4e-3);
                    EXPECT_GT(measured, 2000U);
                    EXPECT_GT(static_cast<double>(within), 0.88 * static_cast<double>(measured));
                }
            }
}

/// What lies beyond what is missing is no witness: of 60 scans' good points hardly one is left out, and none of those
/// by a distance that it does not have. The bad ones among them are found.
TEST(Gaps, PointsAtTheEndsOfAPartAreJudgedByTheirOwnStretch) {
    const SideCase cases[] = {{"without TE", edges_missing[1]},
                              {"without edges", [](double t) { return t < 1.0 || (t > 2.0 && t < 3.0); }},
                              {"front half", [](double t) { return t > 1.5 && t < 3.5; }},
                              {"rear half", [](double t) { return t < 1.5 || t > 3.5; }},
                              {"TE alone", [](double t) { return t < 1.9 || t > 3.1; }}};
    for (const auto& one : cases) {
        SCOPED_TRACE(one.name);
        std::size_t good = 0, lost = 0, bad = 0, missed = 0;
        for (const auto family : families::all_families)
            for (std::uint64_t seed = 1; seed <= 20; ++seed) {
                PartialScan partial(family, one.missing, 1e-3, seed);
                const auto nominal = nominal_of(partial.blade);
                partial.options.nominal = &nominal.curve();
                const auto fit = partial.fit();
                for (std::size_t i = 0; i < partial.points.size(); ++i) {
                    const bool rejected = fit.verdicts[i].reason != RejectReason::none;
                    if (partial.bad[i] == 0.0) {
                        ++good;
                        lost += rejected ? 1 : 0;
                        EXPECT_LT(std::abs(fit.verdicts[i].residual_mm), 0.02);
                    } else if (std::abs(partial.bad[i]) > 0.02) {
                        ++bad;
                        missed += rejected ? 0 : 1;
                    }
                }
            }
        EXPECT_LE(1000 * lost, 2 * good);
        EXPECT_LE(200 * missed, bad);
    }
}

/// Two of them next to each other where points lie wide: without them there is a gap, but the points on both sides of
/// it are there and bear witness.
TEST(Gaps, BadPointsThatLeaveAGapBehindStayBad) {
    PartialScan partial(
        families::Family::fan, [](double t) { return t > 3.87 || t < 1.4; }, 1e-3, 3);
    const auto nominal = nominal_of(partial.blade);
    partial.options.nominal = &nominal.curve();
    const auto fit = partial.fit();
    std::size_t bad = 0;
    for (std::size_t i = 0; i < partial.points.size(); ++i) {
        if (std::abs(partial.bad[i]) <= 0.02) continue;
        ++bad;
        EXPECT_NE(fit.verdicts[i].reason, RejectReason::none) << partial.bad[i];
    }
    EXPECT_GE(bad, 2U);
}

/// Wherever on a side it lies, also beside an edge, where what is missing cannot be told from the dense points alone.
TEST(Gaps, ASideMayMissAnyStretch) {
    for (const auto family : families::all_families)
        for (const double begin : {1.05, 1.3, 1.6, 1.89, 3.01, 3.25, 3.7, 3.89})
            for (const double width : {0.1, 0.25}) {
                if (std::floor(begin + width) > std::floor(begin)) continue;
                SCOPED_TRACE(families::to_string(family) + " " + std::to_string(begin) + " " + std::to_string(width));
                const PartialScan partial(family, [&](double t) { return t > begin && t < begin + width; });
                const auto fit = partial.fit();
                EXPECT_LT(largest_error(partial.blade, fit), 4e-3);
                // As many points as of a section that was measured all round.
                const double points = static_cast<double>(fit.contour.size()) * (1.0 - unmeasured_share(fit));
                EXPECT_NEAR(points, static_cast<double>(SectionOptions().contour_points), 24.0);
            }
}

/// The model of an edge says nothing of a side beyond a gap, and is not joined to it.
TEST(Gaps, AnEdgeIsNotJoinedToASideBeyondAGap) {
    for (const std::uint64_t seed : {1U, 7U})
        for (const double begin : {0.8, 0.9})
            for (const double end : {1.2, 1.4}) {
                SCOPED_TRACE(std::to_string(seed) + " " + std::to_string(begin) + " " + std::to_string(end));
                const auto missing = [&](double t) { return t > begin && t < end; };
                const PartialScan partial(families::Family::fan, missing, 1e-3, seed, seed);
                const auto fit = partial.fit();
                EXPECT_TRUE(fit.le.valid);
                EXPECT_FALSE(fit.le.used_in_contour);
                EXPECT_LT(largest_error(partial.blade, fit), 2e-3);
            }
}

/// A bad point beside a gap has no witness beyond: what it does to the contour is not shown as measured.
TEST(Gaps, BadPointsBesideAGapDoNoHarm) {
    for (const auto family : families::all_families)
        for (const double off_mm : {0.03, 0.1, -0.3})
            for (const std::size_t count : {1U, 2U, 3U}) {
                SCOPED_TRACE(families::to_string(family) + " " + std::to_string(off_mm) + " " + std::to_string(count));
                PartialScan partial(family, on_suction_side);
                auto& points = partial.points;
                std::vector<Vec2> sorted = points;
                // Nearest to where the gap begins.
                const Vec2 end = partial.blade.ball_centre(3.4, 1.0);
                std::sort(sorted.begin(), sorted.end(),
                          [&](const Vec2& a, const Vec2& b) { return (a - end).norm() < (b - end).norm(); });
                for (std::size_t i = 0; i < count; ++i) {
                    Vec2& bad = *std::find(points.begin(), points.end(), sorted[i]);
                    bad += off_mm * partial.blade.at(partial.blade.closest(bad).t).normal();
                }
                EXPECT_LT(largest_error(partial.blade, partial.fit()), 6e-3);
            }
}

TEST(Gaps, AFewBadPointsInARowLeaveNone) {
    PartialScan partial(families::Family::compressor, nothing);
    for (std::size_t i = 300; i < 305; ++i)
        partial.points[i] *= 1.01;
    const auto fit = partial.fit();
    EXPECT_GE(fit.rejected, 5U);
    EXPECT_EQ(unmeasured_share(fit), 0.0);
}

/// Half of what a number rests on: the share says so.
TEST(Gaps, NumbersSayHowMuchOfThemWasNotMeasured) {
    const auto fit = PartialScan(families::Family::fan, on_suction_side).fit();
    const auto unmeasured =
        std::find_if(fit.contour.begin(), fit.contour.end(), [](const auto& p) { return !p.measured; });
    ASSERT_NE(unmeasured, fit.contour.end());
    Sensitivity both;
    both.add(0, 1.0);
    both.add(static_cast<std::size_t>(unmeasured - fit.contour.begin()), -1.0);
    EXPECT_DOUBLE_EQ(fit.contour_noise.of(fit.contour, both).in_gaps, 0.5);
    Sensitivity nose;
    nose.add(0, 1.0);
    EXPECT_EQ(fit.contour_noise.of(fit.contour, nose).in_gaps, 0.0);
}

TEST(Gaps, AFewPointsOfASideAreNoSection) {
    PartialScan partial(families::Family::fan, [](double t) { return t < 3.45 || t > 3.55; });
    const auto nominal = nominal_of(partial.blade);
    partial.options.nominal = &nominal.curve();
    ASSERT_GE(partial.points.size(), 16U);
    const auto fit = fit_section(partial.points, {}, partial.options);
    ASSERT_FALSE(fit);
    EXPECT_NE(fit.error().message.find("too few points beside it"), std::string::npos) << fit.error().message;
}

TEST(Gaps, OneSideAloneIsOpenWithoutANominal) {
    const PartialScan partial(families::Family::turbine, [](double t) { return t < 3.0; });
    const auto fit = fit_section(partial.points, {}, partial.options);
    ASSERT_FALSE(fit);
    EXPECT_NE(fit.error().message.find("without a nominal nothing tells the way"), std::string::npos)
        << fit.error().message;
}

}  // namespace
}  // namespace cmm::fitting
