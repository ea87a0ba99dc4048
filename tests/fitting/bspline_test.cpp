// SPDX-License-Identifier: Apache-2.0
#include "fitting/bspline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/rng.hpp"
#include "fitting/bspline_pieces.hpp"
#include "support/recursion.hpp"

namespace cmm::fitting {
namespace {

std::vector<Vec2> random_controls(std::size_t n, core::Rng& rng) {
    std::vector<Vec2> controls;
    for (std::size_t i = 0; i < n; ++i)
        controls.emplace_back(rng.uniform(-3, 3), rng.uniform(-3, 3));
    return controls;
}

/// Clamped, with a double knot inside where there is room.
BSpline<2> open_curve(int degree, std::size_t controls, std::uint64_t seed) {
    core::Rng rng(seed);
    const auto p = static_cast<std::size_t>(degree);
    std::vector<double> knots(p + 1, -1.0);
    for (std::size_t i = p + 1; i < controls; ++i)
        knots.push_back(i == p + 3 && degree > 1 ? knots.back() : knots.back() + 0.2 + rng.uniform());
    knots.insert(knots.end(), p + 1, knots.back() + 0.7);
    return BSpline<2>::make(degree, knots, random_controls(controls, rng), false).value();
}

BSpline<2> closed_curve(int degree, std::size_t controls, std::uint64_t seed) {
    core::Rng rng(seed);
    const auto p = static_cast<std::size_t>(degree);
    std::vector<double> base{0.5};
    while (base.size() < controls)
        base.push_back(base.back() + 0.2 + rng.uniform());
    const double period = base.back() + 0.6 - base.front();
    std::vector<double> knots;
    for (std::size_t j = 0; j < controls + 2 * p + 1; ++j) {
        const auto turns = std::floor((static_cast<double>(j) - degree) / static_cast<double>(controls));
        knots.push_back(base[(j + 4 * controls - p) % controls] + turns * period);
    }
    return BSpline<2>::make(degree, knots, random_controls(controls, rng), true).value();
}

std::vector<BSpline<2>> curves() {
    return {open_curve(1, 5, 1),    open_curve(2, 6, 2),   open_curve(3, 4, 3),   open_curve(3, 11, 4),
            open_curve(5, 9, 5),    closed_curve(1, 4, 6), closed_curve(2, 5, 7), closed_curve(3, 4, 8),
            closed_curve(3, 12, 9), closed_curve(4, 8, 1)};
}

Vec2 by_recursion(const BSpline<2>& curve, double t) {
    Vec2 sum = Vec2::Zero();
    for (std::size_t i = 0; i + static_cast<std::size_t>(curve.degree()) + 1 < curve.knots().size(); ++i)
        sum += truth::basis(curve.knots(), i, curve.degree(), t) * curve.controls()[i % curve.controls().size()];
    return sum;
}

template <class What>
void along(const BSpline<2>& curve, const What& what) {
    const double length = curve.back() - curve.front();
    for (int k = 0; k < 97; ++k)
        what(curve.front() + length * k / 97.0);
}

double largest_difference(const BSpline<2>& a, const BSpline<2>& b) {
    double worst = 0.0;
    along(a, [&](double t) { worst = std::max(worst, (a.position(t) - b.position(t)).norm()); });
    return worst;
}

TEST(BSpline, IsTheSumOfTheRecursion) {
    for (const auto& curve : curves())
        along(curve, [&](double t) {
            EXPECT_LT((curve.position(t) - by_recursion(curve, t)).norm(), 1e-13) << curve.degree() << " " << t;
        });
}

TEST(BSpline, DerivativesAreTheLimitsOfDifferences) {
    for (const auto& curve : curves()) {
        along(curve, [&](double t) {
            const auto d = curve.derivatives(t, 3);
            EXPECT_LT((d[0] - curve.position(t)).norm(), 1e-13);
            const double e = 1e-6;
            if (t - e < curve.front() ||
                knot_span(curve.knots(), curve.degree(), t - e) != knot_span(curve.knots(), curve.degree(), t + e))
                return;
            const auto before = curve.derivatives(t - e, 2), after = curve.derivatives(t + e, 2);
            for (std::size_t m = 0; m < 3; ++m)
                EXPECT_LT(((after[m] - before[m]) / (2.0 * e) - d[m + 1]).norm(), 1e-6 * (1.0 + d[m + 1].norm()))
                    << curve.degree() << " order " << m + 1 << " at " << t;
        });
    }
}

TEST(BSpline, EndsAreClampedAndPeriodsGoRound) {
    const auto open = open_curve(3, 9, 4);
    EXPECT_LT((open.position(open.front()) - open.controls().front()).norm(), 1e-15);
    EXPECT_LT((open.position(open.back()) - open.controls().back()).norm(), 1e-15);
    EXPECT_LT((open.position(open.back() + 5.0) - open.controls().back()).norm(), 1e-15) << "clamped to the domain";
    const auto closed = closed_curve(3, 8, 4);
    const double period = closed.back() - closed.front();
    for (const double turns : {-2.0, 1.0, 3.0})
        EXPECT_LT((closed.position(1.3) - closed.position(1.3 + turns * period)).norm(), 1e-12);
    const auto seam = closed.derivatives(closed.front(), 2), before = closed.derivatives(closed.back() - 1e-9, 2);
    for (std::size_t m = 0; m < 3; ++m)
        EXPECT_LT((seam[m] - before[m]).norm(), 1e-6);
}

TEST(BSpline, AnInsertedKnotLeavesTheCurve) {
    core::Rng rng(3);
    for (BSpline<2> curve : curves()) {
        const BSpline<2> before = curve;
        for (int k = 0; k < 12; ++k) {
            const double t = k == 0 && curve.closed() ? curve.front()
                                                      : curve.front() + (curve.back() - curve.front()) * rng.uniform();
            const auto finer = curve.with_knot(t);
            if (!finer) continue;
            EXPECT_EQ(finer->controls().size(), curve.controls().size() + 1);
            curve = *finer;
        }
        EXPECT_GT(curve.controls().size(), before.controls().size() + 8);
        EXPECT_LT(largest_difference(before, curve), 1e-13) << before.degree() << before.closed();
    }
}

TEST(BSpline, ARepeatedKnotIsRefusedAboveTheDegree) {
    for (BSpline<2> curve : {open_curve(3, 9, 1), closed_curve(3, 9, 1)}) {
        const BSpline<2> before = curve;
        const double t = 0.5 * (curve.front() + curve.back());
        for (int k = 0; k < 3; ++k)
            curve = curve.with_knot(t).value();
        EXPECT_FALSE(curve.with_knot(t));
        EXPECT_FALSE(curve.with_knot(curve.back() + 1.0));
        EXPECT_FALSE(curve.with_knot(std::nan("")));
        EXPECT_LT(largest_difference(before, curve), 1e-13);
    }
}

TEST(BSpline, WhatWasInsertedIsRemovedAgain) {
    for (const BSpline<2>& before : curves()) {
        BSpline<2> curve = before;
        core::Rng rng(12);
        for (int k = 0; k < 6; ++k)
            curve = curve.with_knot(curve.front() + (curve.back() - curve.front()) * rng.uniform()).value();
        const auto coarser = curve.reduced(1e-9);
        EXPECT_LE(coarser.curve.controls().size(), before.controls().size()) << before.degree() << before.closed();
        EXPECT_LE(coarser.error, 1e-9);
        EXPECT_LT(largest_difference(before, coarser.curve), 1e-9);
    }
}

TEST(BSpline, TheBoundOfARemovalHolds) {
    double tightest = 0.0;
    for (const BSpline<2>& curve :
         {open_curve(3, 30, 2), closed_curve(3, 30, 3), closed_curve(2, 20, 4), open_curve(4, 25, 5)}) {
        for (std::size_t r = 0; r < curve.knots().size(); ++r) {
            const auto removal = curve.without_knot(r);
            const bool inner = curve.knots()[r] > curve.front() && curve.knots()[r] < curve.back();
            ASSERT_EQ(removal.has_value(), inner) << r;
            if (!removal) continue;
            EXPECT_EQ(removal->curve.controls().size(), curve.controls().size() - 1);
            const double difference = largest_difference(curve, removal->curve);
            EXPECT_LE(difference, removal->error * (1.0 + 1e-12));
            tightest = std::max(tightest, difference / removal->error);
        }
        for (const double tolerance : {0.1, 0.5, 2.0}) {
            const auto coarser = curve.reduced(tolerance);
            EXPECT_LE(coarser.error, tolerance);
            EXPECT_LE(largest_difference(curve, coarser.curve), coarser.error + 1e-12);
            if (tolerance > 1.0) {
                EXPECT_LT(coarser.curve.controls().size(), curve.controls().size());
            }
        }
    }
    EXPECT_GT(tightest, 0.5) << "the bound is no wild overestimate";
}

TEST(BSpline, OpeningAClosedCurveKeepsItsShape) {
    for (const BSpline<2>& curve : curves()) {
        const BSpline<2> opened = curve.opened();
        EXPECT_FALSE(opened.closed());
        EXPECT_LT(largest_difference(curve, opened), 1e-13);
        EXPECT_LT((opened.controls().front() - curve.position(curve.front())).norm(), 1e-13);
        const auto p = static_cast<std::size_t>(curve.degree());
        for (std::size_t j = 0; j <= p; ++j) {
            EXPECT_EQ(opened.knots()[j], curve.front());
            EXPECT_EQ(opened.knots()[opened.knots().size() - 1 - j], curve.back());
        }
    }
}

TEST(BSpline, PiecesThereAndBack) {
    for (const BSpline<2>& curve : {open_curve(3, 12, 2), closed_curve(3, 4, 1), closed_curve(3, 15, 2)}) {
        const auto pieces = to_piecewise(curve);
        ASSERT_TRUE(pieces);
        along(curve, [&](double t) {
            const auto d = curve.derivatives(t, 2);
            const Jet jet = pieces->jet(t);
            EXPECT_LT((jet.position - d[0]).norm(), 1e-12);
            EXPECT_LT((jet.d1 - d[1]).norm(), 1e-11);
            EXPECT_LT((jet.d2 - d[2]).norm(), 1e-10);
        });
        const auto back = to_bspline(*pieces);
        ASSERT_TRUE(back);
        EXPECT_EQ(back->controls().size(), curve.controls().size()) << "double knots stay double";
        for (std::size_t j = 0; j < curve.controls().size(); ++j)
            EXPECT_LT((back->controls()[j] - curve.controls()[j]).norm(), 1e-11);
    }
    EXPECT_FALSE(to_piecewise(open_curve(2, 6, 1)));
    EXPECT_FALSE(to_bspline(PiecewiseCubic(
        {0, 1, 2}, {{Vec2(0, 0), Vec2(1, 0), Vec2(0, 0), Vec2(0, 0)}, {Vec2(2, 0), Vec2(1, 0), Vec2(0, 0), Vec2(0, 0)}},
        false)))
        << "a jump";
    EXPECT_FALSE(to_bspline(PiecewiseCubic()));
}

TEST(BSpline, CornersBecomeTripleKnots) {
    const PiecewiseCubic corner(
        {0, 1, 2}, {{Vec2(0, 0), Vec2(1, 0), Vec2(0, 0), Vec2(0, 0)}, {Vec2(1, 0), Vec2(0, 1), Vec2(0, 1), Vec2(0, 0)}},
        false);
    const auto curve = to_bspline(corner);
    ASSERT_TRUE(curve);
    EXPECT_EQ(curve->controls().size(), 7U);
    for (double t = 0.0; t <= 2.0; t += 0.05)
        EXPECT_LT((curve->position(t) - corner.jet(t).position).norm(), 1e-14);
}

TEST(BSpline, RefusesWhatIsNone) {
    const std::vector<Vec2> four(4, Vec2::Zero());
    const std::vector<double> clamped{0, 0, 0, 0, 1, 1, 1, 1};
    EXPECT_TRUE(BSpline<2>::make(3, clamped, four, false));
    EXPECT_FALSE(BSpline<2>::make(0, clamped, four, false));
    EXPECT_FALSE(BSpline<2>::make(12, clamped, four, false));
    EXPECT_FALSE(BSpline<2>::make(3, clamped, std::vector<Vec2>(3, Vec2::Zero()), false));
    EXPECT_FALSE(BSpline<2>::make(3, {0, 0, 0, 0, 1, 1, 1}, four, false));
    EXPECT_FALSE(BSpline<2>::make(3, {0, 0, 0, 1, 0, 1, 1, 1}, four, false));
    EXPECT_FALSE(BSpline<2>::make(3, {0, 0, 0, 0, std::nan(""), 1, 1, 1}, four, false));
    EXPECT_FALSE(BSpline<2>::make(3, std::vector<double>(8, 1.0), four, false));
    EXPECT_FALSE(BSpline<2>::make(3, clamped, {{0, 0}, {1, 1}, {std::nan(""), 0}, {2, 2}}, false));
    std::vector<double> uniform(11);
    std::iota(uniform.begin(), uniform.end(), 0.0);
    EXPECT_TRUE(BSpline<2>::make(3, uniform, four, true));
    uniform[10] = 10.5;
    EXPECT_FALSE(BSpline<2>::make(3, uniform, four, true));
    EXPECT_FALSE(open_curve(3, 4, 1).without_knot(4));
}

}  // namespace
}  // namespace cmm::fitting
