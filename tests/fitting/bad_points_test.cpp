// SPDX-License-Identifier: Apache-2.0
/// What the search for bad points promises, over the three families of blades, counted point by point.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/outliers.hpp"
#include "fitting/section.hpp"
#include "support/families.hpp"
#include "support/twisted_blade.hpp"

namespace cmm::fitting {
namespace {

using families::BladeScan;
using families::Family;
using families::ScanOptions;

struct Tally {
    std::size_t bad = 0, missed = 0, good = 0, lost = 0;

    void add(const BladeScan& scan, std::size_t i, bool rejected) {
        if (scan.bad[i] != 0.0) {
            ++bad;
            missed += !rejected;
        } else {
            ++good;
            lost += rejected;
        }
    }
    void add(const Tally& other) {
        bad += other.bad;
        missed += other.missed;
        good += other.good;
        lost += other.lost;
    }
    double found_percent() const { return 100.0 - 100.0 * static_cast<double>(missed) / static_cast<double>(bad); }
    double lost_percent() const { return 100.0 * static_cast<double>(lost) / static_cast<double>(good); }
    void print(const std::string& what) const {
        std::cout << what << ": found " << found_percent() << " % of " << bad << ", good points lost " << lost_percent()
                  << " % of " << good << "\n";
    }
};

template <class Judge>
Tally tally(Family family, ScanOptions options, std::uint64_t blades, std::uint64_t seeds, const Judge& judge) {
    Tally sum;
    for (std::uint64_t number = 1; number <= blades; ++number) {
        const families::Blade blade = families::make(family, 100 + number);
        for (std::uint64_t seed = 0; seed < seeds; ++seed) {
            options.seed = 1000 * number + seed;
            options.clockwise = seed % 2 == 1;
            const BladeScan scan = families::scan(blade, options);
            const std::vector<char> rejected = judge(scan.points);
            for (std::size_t i = 0; i < scan.points.size(); ++i)
                sum.add(scan, i, rejected[i] != 0);
        }
    }
    return sum;
}

Tally by_search(Family family, const ScanOptions& options, std::uint64_t blades, std::uint64_t seeds,
                bool closed = true) {
    return tally(family, options, blades, seeds,
                 [&](const std::vector<Vec2>& points) { return find_bad_points(points, closed, 0.002).bad; });
}

Tally by_section(Family family, const ScanOptions& options, std::uint64_t blades, std::uint64_t seeds) {
    SectionOptions section;
    section.ball_radius_mm = options.ball_mm;
    return tally(family, options, blades, seeds, [&](const std::vector<Vec2>& points) {
        const auto fit = fit_section(points, {}, section);
        EXPECT_TRUE(fit) << (fit ? "" : fit.error().message);
        std::vector<char> rejected(points.size(), 0);
        for (std::size_t i = 0; fit && i < points.size(); ++i)
            rejected[i] = fit->verdicts[i].reason != RejectReason::none;
        return rejected;
    });
}

/// 600 points, 12 % on each edge, 1 um, 1.5 % bad points of 20 to 400 um in runs of 1-3, ball 1 mm.
TEST(BadPointsOfFamilies, AreFoundAndGoodOnesStay) {
    Tally all;
    for (const Family family : families::all_families) {
        const Tally sum = by_section(family, {}, 10, 6);
        sum.print(to_string(family));
        EXPECT_GE(sum.found_percent(), 99.0) << to_string(family);
        EXPECT_LE(sum.lost_percent(), 0.05) << to_string(family);
        all.add(sum);
    }
    EXPECT_GE(all.found_percent(), 99.5);
    EXPECT_LE(all.lost_percent(), 0.003);
}

struct Case {
    std::string name;
    ScanOptions options;
    double found_percent, lost_percent;
};

/// The search alone, where it is harder. Where the sampling does not resolve the shape, good points have to stay.
TEST(BadPointsOfFamilies, InHarderScans) {
    ScanOptions plain, runs, quiet, loud, few, many, bare, coarse, sides;
    runs.shortest_run = 4;
    runs.longest_run = 5;
    quiet.sigma_mm = 0.3e-3;
    loud.sigma_mm = 3e-3;
    loud.bad_low_mm = 0.060;
    few.points = 400;
    many.points = 2000;
    bare.ball_mm = 0.0;
    coarse.side_pitch_mm = 0.4;
    coarse.edge_pitch_mm = 0.1;
    coarse.bad_low_mm = 0.040;
    sides.bad_at_edges = 0.0;
    sides.longest_run = 5;
    for (const Case& one : {Case{"runs of 4 and 5", runs, 99.0, 0.05}, Case{"0.3 um", quiet, 99.5, 0.1},
                            Case{"3 um, from 60 um", loud, 99.5, 0.003}, Case{"400 points", few, 98.5, 0.1},
                            Case{"2 000 points", many, 99.5, 0.02}, Case{"on the part, no ball", bare, 99.0, 0.05},
                            Case{"0.4 mm, edges 0.1 mm, from 40 um", coarse, 99.0, 0.1},
                            Case{"sides, runs up to 5", sides, 99.5, 0.02}}) {
        Tally sum;
        for (const Family family : families::all_families) {
            sum.add(by_search(family, one.options, 10, one.options.points > 1000 ? 4 : 10));
        }
        sum.print(one.name);
        EXPECT_GE(sum.found_percent(), one.found_percent) << one.name;
        EXPECT_LE(sum.lost_percent(), one.lost_percent) << one.name;
    }
}

/// The way of a ball round a bar with a round end and a blunt one, counter-clockwise, at a place along it; how far the
/// points are apart there.
struct BluntBar {
    double half_height_mm, corner_mm, edge_step_mm;
    static constexpr double length_mm = 30.0, side_step_mm = 0.6;

    double quarter() const { return 0.5 * std::numbers::pi * corner_mm; }
    double flat() const { return 2.0 * (half_height_mm - corner_mm); }
    double edge_end() const { return length_mm + 2.0 * quarter() + flat(); }
    double round_begin() const { return edge_end() + length_mm; }
    double whole() const { return round_begin() + std::numbers::pi * half_height_mm; }

    Vec2 at(double s) const {
        const auto on_arc = [](double x, double y, double radius, double along) {
            const double angle = along / radius;
            return Vec2(x + radius * std::sin(angle), y - radius * std::cos(angle));
        };
        const double low = corner_mm - half_height_mm, half_turn = 2.0 * quarter();
        if (s < length_mm) return {s, -half_height_mm};
        if ((s -= length_mm) < quarter()) return on_arc(length_mm, low, corner_mm, s);
        if ((s -= quarter()) < flat()) return {length_mm + corner_mm, low + s};
        if ((s -= flat()) < quarter()) return on_arc(length_mm, -low, corner_mm, s + 0.5 * half_turn);
        if ((s -= quarter()) < length_mm) return {length_mm - s, half_height_mm};
        return on_arc(0.0, 0.0, half_height_mm, s - length_mm + std::numbers::pi * half_height_mm);
    }
    double step_at(double s) const {
        const bool on_side = s < length_mm - 1.0 || (s > edge_end() + 1.0 && s < round_begin() - 1.0);
        return on_side ? side_step_mm : edge_step_mm;
    }
};

struct BluntScan {
    std::vector<Vec2> points;
    std::vector<std::size_t> on_flat;
};

BluntScan scan_of(const BluntBar& bar, std::uint64_t seed) {
    BluntScan scan;
    core::Rng rng(seed);
    for (double s = 0.05 * static_cast<double>(seed) * bar.edge_step_mm; s < bar.whole(); s += bar.step_at(s)) {
        if (std::abs(s - 0.5 * (BluntBar::length_mm + bar.edge_end())) < 0.5 * bar.flat())
            scan.on_flat.push_back(scan.points.size());
        scan.points.push_back(bar.at(s) + 1e-4 * Vec2(rng.normal(), rng.normal()));
    }
    return scan;
}

template <class Check>
void on_blunt_edges(const Check& check) {
    for (const double corner_mm : {1.02, 1.1, 1.2})
        for (const double step_mm : {0.18, 0.22, 0.26})
            for (std::uint64_t seed = 0; seed < 20; ++seed)
                check(scan_of({1.6, corner_mm, step_mm}, seed));
}

/// Three to six points on the flat between two corners: no polynomial goes through them and the arcs, but the ball's
/// way bends nowhere else than on an arc.
TEST(BadPoints, OnCoarseBluntEdgesGoodOnesStay) {
    std::size_t scans = 0, lost = 0;
    on_blunt_edges([&](const BluntScan& scan) {
        ++scans;
        lost += find_bad_points(scan.points, true, 0.002).count;
    });
    EXPECT_EQ(lost, 0U) << "in " << scans << " scans";
}

/// One point in the middle of the flat. Neighbours that turn so far are poor witnesses: where it stays, good ones go.
TEST(BadPoints, OnCoarseBluntEdgesMostAreFound) {
    std::size_t bad = 0, missed = 0;
    for (const double off_mm : {-0.06, -0.03, 0.03, 0.06}) {
        on_blunt_edges([&](BluntScan scan) {
            const std::size_t there = scan.on_flat[scan.on_flat.size() / 2];
            scan.points[there].x() += off_mm;
            ++bad;
            missed += !find_bad_points(scan.points, true, 0.002).bad[there];
        });
    }
    EXPECT_LE(missed, 160U) << "of " << bad;
}

TEST(BadPointsOfFamilies, OpenChainsAndTheirEnds) {
    Tally sum, ends;
    for (const Family family : families::all_families) {
        const families::Blade blade = families::make(family, 3);
        for (std::uint64_t seed = 0; seed < 40; ++seed) {
            ScanOptions options;
            options.seed = seed;
            BladeScan scan = families::scan(blade, options);
            // A stretch that begins and ends with a run of one to three bad points.
            const std::size_t first = 30 + 7 * seed, count = 160, run = 1 + seed % 3;
            std::vector<Vec2> points(scan.points.begin() + static_cast<std::ptrdiff_t>(first),
                                     scan.points.begin() + static_cast<std::ptrdiff_t>(first + count));
            std::vector<char> truth(count, 0);
            for (std::size_t i = 0; i < count; ++i)
                truth[i] = scan.bad[first + i] != 0.0;
            for (std::size_t k = 0; k < run; ++k) {
                for (const std::size_t i : {k, count - 1 - k}) {
                    const auto jet = blade.at(scan.t[first + i]);
                    points[i] = jet.position + (options.ball_mm + 0.06) * jet.normal();
                    truth[i] = 2;
                }
            }
            const auto found = find_bad_points(points, false, 0.002);
            for (std::size_t i = 0; i < count; ++i) {
                Tally& one = truth[i] == 2 ? ends : sum;
                one.bad += truth[i] != 0;
                one.missed += truth[i] != 0 && !found.bad[i];
                one.good += truth[i] == 0;
                one.lost += truth[i] == 0 && found.bad[i];
            }
        }
    }
    sum.print("open chains");
    EXPECT_GE(sum.found_percent(), 98.0);
    EXPECT_LE(sum.lost_percent(), 0.2);
    std::cout << "their ends: found " << ends.found_percent() << " % of " << ends.bad << "\n";
    EXPECT_GE(ends.found_percent(), 65.0);  // an end has neighbours on one side only
}

/// On edges round which a small ball's centre goes in a narrow turn, points that lie beyond the middle of that turn.
TEST(BadPointsOfFamilies, DeeperThanTheTurnOfTheBallAreFound) {
    Tally all;
    for (const Family family : families::all_families)
        for (std::uint64_t number = 1; number <= 3; ++number) {
            const families::Blade blade = families::make(family, number);
            ScanOptions options;
            options.ball_mm = 0.25;
            options.bad_share = 0.0;
            const BladeScan scan = families::scan(blade, options);
            SectionOptions section;
            section.ball_radius_mm = options.ball_mm;
            for (std::size_t first = 0; first + 2 < scan.points.size(); first += 7) {
                const auto part = families::Blade::part_of(scan.t[first]);
                if (part != families::Part::le && part != families::Part::te) continue;
                BladeScan bad = scan;
                const std::size_t run = 1 + first % 3;
                for (std::size_t i = first; i < first + run; ++i) {
                    bad.bad[i] = -0.4 + 0.02 * static_cast<double>(i - first);
                    bad.points[i] += bad.bad[i] * blade.at(scan.t[i]).normal();
                }
                const auto fit = fit_section(bad.points, {}, section);
                ASSERT_TRUE(fit) << families::to_string(family) << " " << number << ", " << run << " from " << first
                                 << ": " << fit.error().message;
                for (std::size_t i = 0; i < bad.points.size(); ++i)
                    all.add(bad, i, fit->verdicts[i].reason != RejectReason::none);
            }
        }
    EXPECT_EQ(all.missed, 0U) << "of " << all.bad;
    EXPECT_LE(all.lost, 2U) << "of " << all.good;
}

/// 102, 197 and 31 um, a point each tenth of a millimetre, in 5 um of noise: judged with the others of its run among
/// its neighbours none is far off what they foretell, which is worth little.
TEST(BadPointsOfFamilies, SteepRunsDoNotExcuseThemselves) {
    const families::TwistedBlade blade(Family::turbine, 2);
    ScanOptions scanning;
    scanning.sigma_mm = 5e-3;
    scanning.seed = 2;
    const auto rows = families::scan_rows(blade, 25, 2.0, blade.height() - 2.0, scanning);
    std::vector<Vec2> lowest;
    for (const auto& point : rows.rows.front())
        lowest.push_back(point.head<2>());
    SectionOptions options;
    options.ball_radius_mm = 1.0;
    const auto fit = fit_section(lowest, {}, options);
    ASSERT_TRUE(fit) << fit.error().message;
    const auto& bad = rows.bad.front();
    std::size_t high = 0;
    for (std::size_t i = 0; i < bad.size(); ++i) {
        if (std::abs(bad[i]) < 0.08) continue;
        ++high;
        EXPECT_NE(fit->verdicts[i].reason, RejectReason::none) << i << ": " << 1e3 * bad[i] << " um";
    }
    EXPECT_GE(high, 4U);
}

/// Beside bad ones at a joint: the curve alone does not know the way there, the edge as a whole does.
TEST(BadPointsOfFamilies, GoodPointsThatWentWithThemComeBackWhereTheEdgeKnows) {
    Tally sum;
    for (const std::uint64_t number : {483, 817}) {
        const families::Blade blade = families::make(Family::fan, number);
        ScanOptions scanning;
        scanning.seed = number + 7777;
        const BladeScan scan = families::scan(blade, scanning);
        SectionOptions options;
        options.ball_radius_mm = scanning.ball_mm;
        const auto fit = fit_section(scan.points, {}, options);
        ASSERT_TRUE(fit) << fit.error().message;
        for (std::size_t i = 0; i < scan.points.size(); ++i)
            sum.add(scan, i, fit->verdicts[i].reason != RejectReason::none);
    }
    sum.print("beside joints");
    EXPECT_EQ(sum.missed, 0U);
    EXPECT_EQ(sum.lost, 0U);
}

TEST(BadPointsOfFamilies, EveryOneHasItsResidualAndItsThreshold) {
    ScanOptions options;
    options.bad_share = 0.03;
    const auto scan = families::scan(families::make(Family::compressor, 2), options);
    const auto found = find_bad_points(scan.points, true, 0.002);
    for (std::size_t i = 0; i < scan.points.size(); ++i) {
        EXPECT_GT(found.threshold_mm[i], 0.0) << i;
        if (!found.bad[i]) continue;
        EXPECT_GT(std::abs(found.residual[i]), found.threshold_mm[i]) << i;
        EXPECT_NEAR(found.residual[i], scan.bad[i], 0.02 + 0.1 * std::abs(scan.bad[i])) << i << ": outwards positive";
    }
    EXPECT_NEAR(found.sigma_mm, options.sigma_mm, 0.2 * options.sigma_mm);
}

}  // namespace
}  // namespace cmm::fitting
