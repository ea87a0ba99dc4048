// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "fitting/bspline_pieces.hpp"
#include "fitting/closed_curve.hpp"
#include "fitting/curve_samples.hpp"
#include "fitting/least_squares.hpp"
#include "fitting/nurbs.hpp"
#include "support/random_values.hpp"

namespace cmm::fitting {
namespace {

const int seeded = same_cases(1000);

/// Degree, knots with repetitions, controls: clamped or closed.
BSpline<2> any_bspline() {
    const int degree = *whole(1, 6);
    const bool closed = *rc::gen::arbitrary<bool>();
    const auto p = static_cast<std::size_t>(degree);
    const auto controls = static_cast<std::size_t>(*whole(degree + 1, 30));
    const std::size_t inner = closed ? controls : controls - p;
    std::vector<double> base;
    double at = *real(-5.0, 5.0);
    std::size_t times = closed ? 1 : degree + 1;
    for (std::size_t i = 0; i < inner; ++i) {
        const bool repeat = i > 1 && times < p && *whole(0, 5) == 0;
        times = repeat ? times + 1 : 1;
        if (!repeat) at += *real(0.05, 2.0);
        base.push_back(at);
    }
    std::vector<double> knots;
    const double end = at + *real(0.05, 2.0);
    if (closed) {
        for (std::size_t j = 0; j < controls + 2 * p + 1; ++j) {
            const auto turn = std::floor((static_cast<double>(j) - degree) / static_cast<double>(controls));
            knots.push_back(base[(j + 9 * controls - p) % controls] + turn * (end - base[0]));
        }
    } else {
        knots.assign(p, base[0]);
        knots.insert(knots.end(), base.begin(), base.end());
        knots.insert(knots.end(), p + 1, end);
    }
    const auto polygon = *rc::gen::container<std::vector<Vec2>>(controls, point(50.0));
    return BSpline<2>::make(degree, knots, polygon, closed).value();
}

RC_GTEST_PROP(Properties, PartitionOfUnity, ()) {
    const BSpline<2> curve = any_bspline();
    const double t = *real(curve.front(), curve.back());
    const BasisValues basis = basis_functions(curve.knots(), curve.degree(), t, 1);
    double sum = 0.0, slopes = 0.0, steepest = 0.0;
    for (std::size_t a = 0; a <= static_cast<std::size_t>(curve.degree()); ++a) {
        RC_ASSERT(basis.of[0][a] >= 0.0);
        sum += basis.of[0][a];
        slopes += basis.of[1][a];
        steepest = std::max(steepest, std::abs(basis.of[1][a]));
    }
    RC_ASSERT(std::abs(sum - 1.0) < 1e-14);
    RC_ASSERT(std::abs(slopes) <= 1e-13 * steepest);
}

RC_GTEST_PROP(Properties, AKnotInsertedLeavesTheCurve, ()) {
    const BSpline<2> curve = any_bspline();
    const auto finer = curve.with_knot(*real(curve.front(), curve.back()));
    RC_PRE(finer.has_value());
    for (int k = 0; k < 20; ++k) {
        const double t = *real(curve.front(), curve.back());
        RC_ASSERT((finer->position(t) - curve.position(t)).norm() < 1e-12);
    }
}

RC_GTEST_PROP(Properties, ARemovedKnotMovesTheCurveByItsBoundAtMost, ()) {
    const BSpline<2> curve = any_bspline();
    const auto coarser = curve.reduced(*real(0.0, 100.0));
    for (int k = 0; k < 20; ++k) {
        const double t = *real(curve.front(), curve.back());
        RC_ASSERT((coarser.curve.position(t) - curve.position(t)).norm() <= coarser.error + 1e-11);
    }
}

/// A closed outline round the origin, some millimetres to some tens of millimetres wide, points at uneven steps.
std::vector<Vec2> any_outline() {
    const int n = *whole(8, 60);
    const double size = *real(1.0, 40.0), flat = *real(0.1, 1.0), bumps = *real(0.0, 0.2);
    const double phase = *real(0.0, 6.0);
    std::vector<Vec2> points;
    for (int i = 0; i < n; ++i) {
        const double a = 2.0 * std::numbers::pi * (i + *real(0.0, 0.6)) / n;
        const double r = size * (1.0 + bumps * std::sin(3.0 * a + phase));
        points.emplace_back(r * std::cos(a), flat * r * std::sin(a));
    }
    return points;
}

constexpr double same_mm = 1e-9;

/// What is said of corresponding points of two curves that should be the same up to `move`; distances scale.
template <class Move>
void same_curve(const ClosedCurve& a, const ClosedCurve& b, double shift_mm, double scale, const Move& move) {
    RC_ASSERT(std::abs(scale * a.length() - b.length()) < same_mm);
    RC_ASSERT(std::abs(scale * scale * a.area() - b.area()) < same_mm * (1.0 + b.length()));
    for (int k = 0; k < 10; ++k) {
        const double s = a.length() * k / 10.0;
        const CurvePoint p = a.evaluate(s), q = b.evaluate(scale * s + shift_mm);
        RC_ASSERT((move(p.position) - q.position).norm() < same_mm);
        RC_ASSERT(std::abs(p.curvature - scale * q.curvature) < 1e-6 * (1.0 + std::abs(p.curvature)));
        const Vec2 probe = p.position + *real(-0.3, 3.0) * p.normal;
        const ClosestPoint near_a = a.closest(probe), near_b = b.closest(move(probe));
        RC_ASSERT(std::abs(scale * std::abs(near_a.distance_mm) - std::abs(near_b.distance_mm)) < same_mm);
    }
}

RC_GTEST_PROP(Properties, ClosedCurvesMoveWithTheirPoints, ()) {
    const auto points = any_outline();
    const double angle = *real(-3.0, 3.0);
    const Vec2 shift = *point(100.0);
    Eigen::Matrix2d turn;
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    const auto move = [&](const Vec2& p) { return Vec2(turn * p + shift); };
    std::vector<Vec2> moved;
    for (const Vec2& p : points)
        moved.push_back(move(p));
    same_curve(ClosedCurve::through(points).value(), ClosedCurve::through(moved).value(), 0.0, 1.0, move);
}

RC_GTEST_PROP(Properties, ClosedCurvesScaleWithTheirPoints, ()) {
    const auto points = any_outline();
    const double scale = *real(0.2, 3.0);
    const auto move = [&](const Vec2& p) { return Vec2(scale * p); };
    std::vector<Vec2> scaled;
    for (const Vec2& p : points)
        scaled.push_back(move(p));
    same_curve(ClosedCurve::through(points).value(), ClosedCurve::through(scaled).value(), 0.0, scale, move);
}

RC_GTEST_PROP(Properties, ClosedCurvesForgetDirectionAndStart, ()) {
    const auto points = any_outline();
    const auto first = static_cast<std::ptrdiff_t>(*whole<std::size_t>(0, points.size()));
    std::vector<Vec2> turned = points;
    std::rotate(turned.begin(), turned.begin() + first, turned.end());
    if (*rc::gen::arbitrary<bool>()) std::reverse(turned.begin() + 1, turned.end());
    const ClosedCurve a = ClosedCurve::through(points).value(), b = ClosedCurve::through(turned).value();
    const double start = a.arc_length_at(a.spline().breaks()[static_cast<std::size_t>(first)]);
    same_curve(a, b, -start, 1.0, [](const Vec2& p) { return p; });
}

void use(const ClosedCurve& curve) {
    const std::vector<Vec2> asked{{0, 0}, {*garbage(), *garbage()}, {*garbage(), *garbage()}};
    std::vector<ClosestPoint> feet(asked.size());
    curve.closest(asked, feet);
    (void)curve.closest(asked[1], *garbage());
    (void)curve.evaluate(*garbage());
    CurveSamples samples;
    sample_at(curve.spline(), std::vector<double>{*garbage(), *garbage()}, samples);
    (void)to_bspline(curve.spline());
}

RC_GTEST_PROP(Garbage, ClosedCurves, ()) {
    const auto curve = ClosedCurve::through(garbage_points(60));
    if (curve) use(*curve);
}

RC_GTEST_PROP(Garbage, LeastSquares, ()) {
    const auto points = garbage_points(60);
    std::vector<double> t, x, y;
    for (const Vec2& p : points) {
        t.push_back(*garbage());
        x.push_back(p.x());
        y.push_back(p.y());
    }
    auto breaks = *rc::gen::container<std::vector<double>>(garbage());
    if (*rc::gen::arbitrary<bool>()) std::sort(t.begin(), t.end());
    if (*rc::gen::arbitrary<bool>()) std::sort(breaks.begin(), breaks.end());
    const bool closed = *rc::gen::arbitrary<bool>();
    const auto curve = fit_fixed_knots({t, x, y}, breaks, closed);
    if (curve)
        for (const auto& piece : curve->pieces())
            for (const Vec2& coefficient : piece)
                RC_ASSERT(is_finite(coefficient));
}

RC_GTEST_PROP(Garbage, RationalCurves, ()) {
    const auto points = garbage_points(60);
    std::vector<double> weights;
    if (*rc::gen::arbitrary<bool>())
        for (std::size_t i = 0; i < points.size(); ++i)
            weights.push_back(*rc::gen::arbitrary<bool>() ? 1.0 : *garbage());
    const NurbsEnd start = NurbsEnd::along({*garbage(), *garbage()}, *garbage());
    for (const auto& curve :
         {interpolate_nurbs(points, weights, start, NurbsEnd::not_a_knot()),
          interpolate_nurbs(points, {}, NurbsEnd(), NurbsEnd()), interpolate_closed_nurbs(points, weights)}) {
        if (!curve) continue;
        (void)curve->jet(*garbage());
        (void)curve->with_knot(*garbage());
        (void)curve->reduced(*garbage());
    }
}

RC_GTEST_PROP(Garbage, BSplines, ()) {
    const auto knots = *rc::gen::container<std::vector<double>>(garbage());
    const auto curve = BSpline<2>::make(*whole(-1, 12), knots, garbage_points(60), *rc::gen::arbitrary<bool>());
    if (!curve) return;
    (void)curve->position(*garbage());
    (void)curve->with_knot(*garbage());
    (void)curve->reduced(*garbage());
    (void)curve->opened();
}

}  // namespace
}  // namespace cmm::fitting
