// SPDX-License-Identifier: Apache-2.0
#include "fitting/ordering.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <numbers>

#include "core/rng.hpp"
#include "fitting/nominal.hpp"
#include "fitting/outliers.hpp"
#include "fitting/section.hpp"
#include "support/families.hpp"
#include "support/truth.hpp"

namespace cmm::fitting {
namespace {

core::Result<Lap> lap_of(const std::vector<Vec2>& points, const ClosedCurve* nominal = nullptr) {
    SectionOptions options;
    options.reject_floor_mm = 0.010;
    options.nominal = nominal;
    std::vector<char> duplicate;
    return order_lap(points, usable_points(points, std::vector<char>(points.size(), 0), duplicate), options);
}

double longest_step(const std::vector<Vec2>& points, const Lap& lap) {
    double longest = 0.0;
    for (std::size_t k = 0; k < lap.index.size(); ++k)
        longest = std::max(longest, (points[lap.index[(k + 1) % lap.index.size()]] - points[lap.index[k]]).norm());
    return longest;
}

TEST(Ordering, OneLapFromAnyStartEitherWay) {
    const auto centres = truth::ball_centres(truth::envelope_blade({}), 1.0);
    for (int k = 0; k < 40; ++k) {
        truth::ScanOptions options;
        options.start_share = k / 40.0;
        options.clockwise = k % 2 == 1;
        options.bad_share = 0.0;
        const auto scan = truth::scan(centres, options);
        const auto lap = lap_of(scan.points);
        ASSERT_TRUE(lap) << lap.error().message;
        EXPECT_EQ(lap->index.size(), scan.points.size());
        EXPECT_EQ(lap->was_clockwise, options.clockwise);
        EXPECT_TRUE(lap->again.empty());
        EXPECT_LT(longest_step(scan.points, *lap), 0.45);
    }
}

/// A probe that trembles in a corner measures places in the wrong order; along the curve they follow each other again.
TEST(Ordering, PlacesThatTheProbeWentBackToFollowTheCurve) {
    truth::ScanOptions options;
    options.bad_share = 0.0;
    options.noise = 0.0;
    const auto scan = truth::scan(truth::ball_centres(truth::envelope_blade({}), 1.0), options);
    std::vector<Vec2> along, trembled;  // every fourth point; now and then one between two, measured after the second
    std::size_t steps_back = 0;
    for (std::size_t i = 0; i + 4 < scan.points.size(); i += 4) {
        along.push_back(scan.points[i]);
        trembled.push_back(scan.points[i]);
        const double back = (scan.points[i] - scan.points[i - std::min<std::size_t>(i, 1)]).norm();
        if (i % 40 != 24 || back > 0.3 * (scan.points[i] - scan.points[i - 4]).norm()) continue;
        along.insert(along.end() - 1, scan.points[i - 1]);
        trembled.push_back(scan.points[i - 1]);
        ++steps_back;
    }
    ASSERT_GT(steps_back, 4U);
    const auto expected = lap_of(along), lap = lap_of(trembled);
    ASSERT_TRUE(expected && lap);
    EXPECT_LE(lap->again.size(), 2U) << "a step back by half a step or more is a second measurement";
    std::vector<Vec2> wanted, got;
    for (const std::size_t i : expected->index) {
        const auto is_this = [&](std::size_t k) { return trembled[k] == along[i]; };
        if (std::none_of(lap->again.begin(), lap->again.end(), is_this)) wanted.push_back(along[i]);
    }
    for (const std::size_t k : lap->index)
        got.push_back(trembled[k]);
    EXPECT_EQ(got, wanted);
}

/// A step between two bad points goes to the side; that does not put the later one before the other.
TEST(Ordering, BadPointsBesideANoseKeepTheirOrder) {
    // Round a nose of 1 mm in steps of 0.02 mm, then along the side in steps of 0.7; the last two of
    // the nose are bad.
    std::vector<Vec2> points;
    for (int k = -40; k <= 40; ++k)
        points.emplace_back(-std::cos(0.02 * k), -std::sin(0.02 * k));
    const Vec2 along = left_of(Vec2(points.back())), out = points.back();
    points.emplace_back(points.back() + 0.012 * along + 0.25 * out);
    points.emplace_back(points.back() - 0.007 * along + 0.15 * out);
    for (int k = 1; k <= 40; ++k)
        points.emplace_back(out + 0.7 * k * along);
    const Vec2 far = points.back();
    for (int k = 1; k <= 20; ++k)
        points.emplace_back(far + (points.front() - far) * (k / 21.0) +
                            Vec2(8.0 * std::sin(std::numbers::pi * k / 21.0), 0.0));
    const auto lap = lap_of(points);
    ASSERT_TRUE(lap);
    ASSERT_EQ(lap->index.size(), points.size());
    const bool backwards = lap->was_clockwise;
    std::size_t out_of_order = 0;
    for (std::size_t k = 0; k < lap->index.size(); ++k) {
        const std::size_t now = lap->index[k], next = lap->index[(k + 1) % lap->index.size()];
        out_of_order += (backwards ? (next + 1) % points.size() == now : (now + 1) % points.size() == next) ? 0 : 1;
    }
    EXPECT_EQ(out_of_order, 0U);
}

TEST(Ordering, SetsTheOverlapAside) {
    const auto centres = truth::ball_centres(truth::envelope_blade({55, 3, 20, 50, 0.15, 0.12}), 0.5);
    for (const double overlap : {0.5, 3.0, 20.0, 150.0}) {
        for (int k = 0; k < 10; ++k) {
            truth::ScanOptions options;
            options.start_share = k / 10.0;
            options.overlap_mm = overlap;
            options.seed = 50 + k;
            const auto scan = truth::scan(centres, options);
            const auto lap = lap_of(scan.points);
            ASSERT_TRUE(lap) << lap.error().message;
            EXPECT_FALSE(lap->again.empty());
            EXPECT_EQ(lap->index.size() + lap->again.size(), scan.points.size());
            EXPECT_LT(longest_step(scan.points, *lap), 1.0) << overlap << " " << k;
        }
    }
}

/// Wherever bad points lie beside the start of a scan or beside its return there: the good points of the first lap stay
/// in it, and those of the second do not come to it. The last and the first of them lie on one spot.
TEST(Ordering, BadPointsBesideTheStartDoNotMoveTheReturn) {
    constexpr std::size_t lap_points = 600, first_places = 8, before = 4;
    for (const auto family : families::all_families) {
        for (std::uint64_t seed = 1; seed <= 6; ++seed) {
            const auto blade = families::make(family, seed);
            families::ScanOptions scanning;
            scanning.bad_share = 0.0;
            scanning.overlap = 0.02;
            scanning.clockwise = seed % 2 == 0;
            scanning.seed = seed;
            const auto scan = families::scan(blade, scanning);
            for (const std::size_t first : {std::size_t{0}, lap_points - before})
                for (std::size_t place = first; place < first + first_places; ++place)
                    for (std::size_t run = 1; run <= 3; ++run)
                        for (const double off_mm : {-0.3, -0.1, 0.03, 0.3}) {
                            auto points = scan.points;
                            for (std::size_t i = place; i < place + run; ++i)
                                points[i] += off_mm * blade.at(scan.t[i]).normal();
                            const auto lap = lap_of(points);
                            ASSERT_TRUE(lap) << lap.error().message;
                            const auto is_bad = [&](std::size_t i) { return i >= place && i < place + run; };
                            const std::string where = families::to_string(family) + " " + std::to_string(seed) +
                                                      ", bad: " + std::to_string(run) + " from " +
                                                      std::to_string(place) + " by " + std::to_string(off_mm);
                            for (const std::size_t i : lap->index)
                                EXPECT_TRUE(i <= lap_points || is_bad(i)) << i << " in the lap, " << where;
                            for (const std::size_t i : lap->again)
                                EXPECT_TRUE(i + 1 >= lap_points || is_bad(i)) << i << " again, " << where;
                        }
        }
    }
}

TEST(Ordering, TheEndsOfAScanMayBeApart) {
    truth::ScanOptions options;
    options.overlap_mm = -8.0;
    const auto scan = truth::scan(truth::ball_centres(truth::envelope_blade({}), 1.0), options);
    const auto lap = lap_of(scan.points);
    ASSERT_TRUE(lap) << lap.error().text();
    EXPECT_EQ(lap->index.size(), scan.points.size());
    EXPECT_TRUE(lap->again.empty());
    EXPECT_GT(longest_step(scan.points, *lap), 5.0);
}

NominalSection nominal_of(const families::Blade& blade) {
    std::vector<Vec2> outline;
    for (int k = 0; k < 1200; ++k)
        outline.push_back(blade.at(4.0 * k / 1200).position);
    return analyse_nominal(outline, {blade.le().nose, blade.te().nose}).value();
}

/// The polygon's area has the wrong sign for a hollow side; the nominal tells the sense, also of a stretch, and of a
/// part that lies beside it. Points at the ends keep their places: beyond the gap the next one is anywhere.
TEST(Ordering, TheNominalTellsTheSenseOfASideAlone) {
    for (const auto family : families::all_families) {
        const auto blade = families::make(family, 3);
        const auto nominal = nominal_of(blade);
        for (const auto& [from, to] : {std::pair{1.0, 2.0}, {3.0, 4.0}, {1.3, 1.5}})
            for (const bool clockwise : {false, true}) {
                SCOPED_TRACE(families::to_string(family) + " from " + std::to_string(from));
                std::vector<Vec2> points;
                for (int k = 0; k < 120; ++k)
                    points.push_back(blade.ball_centre(from + (to - from) * (k + 0.5) / 120, 1.0) + Vec2(0.6, -0.5));
                if (clockwise) std::reverse(points.begin(), points.end());
                const auto lap = lap_of(points, &nominal.curve());
                ASSERT_TRUE(lap) << lap.error().text();
                EXPECT_EQ(lap->was_clockwise, clockwise);
                ASSERT_EQ(lap->index.size(), points.size());
                for (std::size_t k = 0; k < points.size(); ++k) {
                    const std::size_t next =
                        clockwise ? (k + points.size() - 1) % points.size() : (k + 1) % points.size();
                    const auto here = std::find(lap->index.begin(), lap->index.end(), k);
                    const auto after = here + 1 == lap->index.end() ? lap->index.begin() : here + 1;
                    EXPECT_EQ(*after, next);
                }
            }
    }
}

TEST(Ordering, AnotherBladesNominalTellsNoSense) {
    const auto fan = families::make(families::Family::fan, 3);
    const auto nominal = nominal_of(families::make(families::Family::compressor, 5));
    std::vector<Vec2> points;
    for (int k = 0; k < 120; ++k)
        points.push_back(fan.ball_centre(1.0 + (k + 0.5) / 120, 1.0));
    const auto lap = lap_of(points, &nominal.curve());
    ASSERT_FALSE(lap);
    EXPECT_NE(lap.error().message.find("does not tell on which side"), std::string::npos) << lap.error().message;
}

TEST(Ordering, KeepsOutWhatIsNoPoint) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const std::vector<Vec2> points{{0, 0}, {1, 0}, {1, 0}, {nan, 0}, {2, 0}, {3, 1}, {0, 0}};
    std::vector<char> duplicate;
    const std::vector<char> excluded{0, 0, 0, 0, 0, 1, 0};
    const auto usable = usable_points(points, excluded, duplicate);
    EXPECT_EQ(usable, (std::vector<std::size_t>{0, 1, 4}));
    EXPECT_TRUE(duplicate[2] && duplicate[6]);
    EXPECT_FALSE(lap_of(points));
}

/// A pass over a stretch, its points between those of the lap: the fit of both is that of one lap through all of them.
TEST(Ordering, PointsOfALaterPassGoBetweenThoseOfTheLap) {
    const auto blade = families::make(families::Family::compressor, 3);
    std::vector<Vec2> lap, pass, merged;
    for (int k = 0; k < 800; ++k) {
        const Vec2 centre = blade.ball_centre(4.0 * k / 800, 1.0);
        const bool later = k > 620 && k < 760 && k % 2 == 1;
        (later ? pass : lap).push_back(centre);
        merged.push_back(centre);
    }
    std::vector<Vec2> all = lap;
    all.insert(all.end(), pass.begin(), pass.end());
    std::vector<char> is_later(lap.size(), 0);
    is_later.resize(all.size(), 1);
    SectionOptions options;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    const auto joined = fit_section(all, {}, options, {}, is_later);
    const auto whole = fit_section(merged, {}, options);
    ASSERT_TRUE(joined && whole);
    EXPECT_EQ(joined->rejected, 0U);
    EXPECT_EQ(joined->centres.points.size(), whole->centres.points.size());
    EXPECT_EQ(joined->centres.points, whole->centres.points);
    EXPECT_EQ(joined->chord_mm, whole->chord_mm);
}

/// A lap that misses an edge and half of both sides, a pass that has every other point of them, and one with the rest:
/// the straight line over the gap does not tell their order.
TEST(Ordering, PassesOverAGapKeepTheirOrder) {
    const auto blade = families::make(families::Family::compressor, 3);
    constexpr std::size_t count = 800, half_gap = 200;
    std::vector<Vec2> merged;
    for (std::size_t k = 0; k < count; ++k)
        merged.push_back(blade.ball_centre(4.0 * static_cast<double>(k) / count, 1.0));
    const auto nearer = [&](const Vec2& a, const Vec2& b) {
        return (a - blade.le().nose).norm() < (b - blade.le().nose).norm();
    };
    const auto nose = std::min_element(merged.begin(), merged.end(), nearer);
    std::rotate(merged.begin(), merged.begin() + (nose - merged.begin() + count / 2) % count, merged.end());
    for (const bool backwards : {false, true}) {
        std::array<std::vector<Vec2>, 3> passes;  // the first is the lap
        for (std::size_t k = 0; k < count; ++k)
            passes.at(k < count / 2 - half_gap || k > count / 2 + half_gap ? 0 : 1 + k % 2).push_back(merged[k]);
        if (backwards) std::reverse(passes[1].begin(), passes[1].end());
        std::vector<Vec2> all;
        std::vector<char> pass_of;
        for (std::size_t pass = 0; pass < passes.size(); ++pass) {
            all.insert(all.end(), passes.at(pass).begin(), passes.at(pass).end());
            pass_of.resize(all.size(), static_cast<char>(pass));
        }
        SectionOptions options;
        options.le_hint = blade.le().nose;
        options.te_hint = blade.te().nose;
        const auto joined = fit_section(all, {}, options, {}, pass_of);
        const auto whole = fit_section(merged, {}, options);
        ASSERT_TRUE(whole);
        ASSERT_TRUE(joined) << joined.error().text();
        // It begins elsewhere: at the point that is farthest from the middle of the lap alone.
        auto points = joined->centres.points;
        std::rotate(points.begin(), std::find(points.begin(), points.end(), whole->centres.points.front()),
                    points.end());
        EXPECT_TRUE(points == whole->centres.points) << backwards;
    }
}

/// A bad point of a pass is found among its neighbours of the lap.
TEST(Ordering, ABadPointOfALaterPassIsFound) {
    const auto blade = families::make(families::Family::compressor, 3);
    families::ScanOptions scanning;
    scanning.bad_share = 0.0;
    auto points = families::scan(blade, scanning).points;
    std::vector<char> is_later(points.size(), 0);
    for (int k = 0; k < 40; ++k) {
        const double t = 3.3 + 0.01 * k;
        const auto jet = blade.at(t);
        points.emplace_back(jet.position + (1.0 + (k == 20 ? 0.2 : 0.0)) * jet.normal());
        is_later.push_back(1);
    }
    SectionOptions options;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    const auto fit = fit_section(points, {}, options, {}, is_later);
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->rejected, 1U);
    EXPECT_NE(fit->verdicts[points.size() - 20].reason, RejectReason::none);
}

/// Over a run of bad points a scan of an unknown section may lose its way, go back by two dozen points, and measure the
/// stretch once more: that is no part of the lap.
TEST(Ordering, AStretchThatWasMeasuredOnceMoreIsSetAside) {
    for (const auto family : families::all_families) {
        families::ScanOptions scanning;
        scanning.bad_share = 0.0;
        const auto points = families::scan(families::make(family, 3), scanning).points;
        for (std::size_t from : {60U, 150U, 290U, 430U}) {
            std::vector<Vec2> back(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(from));
            const std::size_t again = from - 24;
            for (std::size_t i = again; i < points.size(); ++i)
                back.push_back(i < from ? Vec2(0.5 * (points[i] + points[i + 1])) : points[i]);
            const auto once = lap_of(points), lap = lap_of(back);
            ASSERT_TRUE(once && lap) << families::to_string(family) << " " << from;
            EXPECT_NEAR(static_cast<double>(lap->again.size()), 24.0, 2.0)
                << families::to_string(family) << " " << from;
            EXPECT_LT(longest_step(back, *lap), 1.6 * longest_step(points, *once));
        }
    }
}

/// Bad points of such a stretch are told by the curve of the lap, with their own distance from it.
TEST(Ordering, BadPointsOfAStretchThatWasMeasuredOnceMoreAreFound) {
    const auto blade = families::make(families::Family::turbine, 3);
    families::ScanOptions scanning;
    scanning.bad_share = 0.0;
    const auto scan = families::scan(blade, scanning);
    const std::size_t from = 290, bad_from = from + 20, bad_to = bad_from + 3;
    std::vector<Vec2> points(scan.points.begin(), scan.points.begin() + from);
    for (std::size_t i = from - 24; i < scan.points.size(); ++i) {
        const bool bad = points.size() >= bad_from && points.size() < bad_to;
        points.push_back(scan.points[i] + (bad ? 0.04 : 0.0) * blade.at(scan.t[i]).normal());
    }
    SectionOptions options;
    options.le_hint = blade.le().nose;
    options.te_hint = blade.te().nose;
    const auto fit = fit_section(points, {}, options);
    ASSERT_TRUE(fit) << fit.error().message;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool bad = i >= bad_from && i < bad_to;
        const auto& verdict = fit->verdicts[i];
        if (verdict.reason == RejectReason::duplicate) continue;
        EXPECT_EQ(verdict.reason != RejectReason::none, bad) << i;
        EXPECT_NEAR(verdict.residual_mm, bad ? 0.04 : 0.0, 5e-3) << i;
    }
}

/// Where bad points and a second measurement of the same stretch come together, who is judged by whom is not clear yet:
/// the section is fitted all the same.
TEST(Ordering, AScanThatStepsBackAmongBadPointsIsFitted) {
    for (const auto family : families::all_families)
        for (std::uint64_t seed = 1; seed <= 10; ++seed)
            for (const bool long_runs : {false, true}) {
                core::Rng rng(seed);
                families::ScanOptions scanning;
                scanning.points = 400;
                scanning.seed = 1000 + seed;
                scanning.bad_share = long_runs ? 0.03 : 0.015;
                scanning.longest_run = long_runs ? longest_bad_run : 3;
                scanning.sigma_mm = long_runs ? 1e-3 : 3e-3;
                const auto scan = families::scan(families::make(family, seed), scanning);
                const auto from = 40 + static_cast<std::size_t>(340.0 * rng.uniform());
                const auto again = from - 8 - static_cast<std::size_t>(20.0 * rng.uniform());
                std::vector<Vec2> points(scan.points.begin(), scan.points.begin() + static_cast<std::ptrdiff_t>(from));
                for (std::size_t i = again; i < from; ++i) {
                    const bool good = scan.bad[i] == 0.0 && scan.bad[i + 1] == 0.0;
                    points.push_back(good ? Vec2(0.5 * (scan.points[i] + scan.points[i + 1]))
                                          : Vec2(scan.points[i] + Vec2(1e-3, 1e-3)));
                }
                points.insert(points.end(), scan.points.begin() + static_cast<std::ptrdiff_t>(from), scan.points.end());
                const auto fit = fit_section(points, {}, {});
                EXPECT_TRUE(fit) << families::to_string(family) << " " << seed << " " << long_runs << ": "
                                 << fit.error().message;
            }
}

/// Where the ball lies still in a hollow (of an engine blade's cooling slot) the points crowd, and trembling steps of
/// some micrometres are beside steps of a tenth of a millimetre. Those are no gaps: the order stays that of the scan.
TEST(Ordering, PointsThatCrowdInAHollowTurnNobodyRound) {
    std::vector<Vec2> points{{17.1389, -4.7381}, {17.1188, -4.7199}, {17.0961, -4.6929}, {17.0746, -4.6696},
                             {17.0278, -4.6271}, {16.9604, -4.5665}, {16.9295, -4.5457}, {16.9335, -4.5466},
                             {16.9365, -4.5494}, {16.9353, -4.5467}, {16.9070, -4.5313}, {16.8830, -4.5131},
                             {16.8615, -4.4942}, {16.8324, -4.4770}, {16.8185, -4.4668}, {16.7945, -4.4488},
                             {16.7731, -4.4327}, {16.7446, -4.4130}};
    const std::size_t measured = points.size();
    const Vec2 middle = 0.5 * (points.front() + points.back()), radius = points.back() - middle;
    for (int k = 1; k < 40; ++k)
        points.push_back(middle + Eigen::Rotation2Dd(std::numbers::pi * k / 40.0) * radius);
    const auto lap = lap_of(points);
    ASSERT_TRUE(lap) << lap.error().message;
    const auto first = std::find(lap->index.begin(), lap->index.end(), std::size_t{0});
    std::vector<std::size_t> in_order(lap->index);
    std::rotate(in_order.begin(), in_order.begin() + (first - lap->index.begin()), in_order.end());
    for (std::size_t i = 0; i < measured; ++i)
        EXPECT_NEAR(static_cast<double>(in_order[i]), static_cast<double>(i), i < 6 || i > 9 ? 0.0 : 2.0) << i;
}

/// Small blades have points on their edges whose distance is that of their noise: single steps go anywhere, and a scan
/// that begins there has not come back before it has.
TEST(Ordering, StartsAmongPointsAsNearAsTheirNoise) {
    constexpr int points_of_edge = 84, points_of_side = 266, all = 2 * (points_of_edge + points_of_side);
    constexpr double chord_share = 0.1;  // 6 mm
    for (const auto family : families::all_families)
        for (std::uint64_t seed = 1; seed <= 40; ++seed) {
            const auto blade = families::make(family, seed);
            core::Rng rng(seed);
            const int start = static_cast<int>(rng.uniform(0, points_of_edge));
            std::vector<Vec2> points;
            for (int k = 0; k < all; ++k) {
                const int i = (start + (seed % 2 == 1 ? k : all - k)) % all;
                const int half = i % (all / 2);
                const double share = half < points_of_edge ? (half + 0.5) / points_of_edge
                                                           : 1.0 + (half - points_of_edge + 0.5) / points_of_side;
                const auto jet = blade.at((i < all / 2 ? 0.0 : 2.0) + share);
                points.push_back(chord_share * jet.position + 1.5e-3 * rng.normal() * jet.normal());
            }
            const auto lap = lap_of(points);
            ASSERT_TRUE(lap) << lap.error().message;
            EXPECT_LE(lap->again.size(), 4U) << families::to_string(family) << ' ' << seed;
        }
}

}  // namespace
}  // namespace cmm::fitting
