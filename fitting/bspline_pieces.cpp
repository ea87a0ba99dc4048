// SPDX-License-Identifier: Apache-2.0
#include "fitting/bspline_pieces.hpp"

#include <algorithm>
#include <string>

#include "fitting/cubic_basis.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

/// The symmetric function that is affine in each argument and equal to the piece when all three agree.
Vec2 polar_form(const PiecewiseCubic::Piece& piece, double x, double y, double z) {
    const auto& [a, b, c, d] = piece;
    return a + (x + y + z) / 3.0 * b + (x * y + y * z + z * x) / 3.0 * c + x * y * z * d;
}

/// Multiplicity of the break between two pieces; 4 when the position jumps.
std::size_t multiplicity(const PiecewiseCubic& curve, std::size_t before, std::size_t after, double allowed) {
    const auto& breaks = curve.breaks();
    const double h = breaks[before + 1] - breaks[before], next = breaks[after + 1] - breaks[after];
    const Jet left = curve.jet_in(before, breaks[before + 1]), right = curve.jet_in(after, breaks[after]);
    const double scale = std::min(h, next);
    if ((left.position - right.position).norm() > allowed) return 4;
    if ((left.d1 - right.d1).norm() * scale > allowed) return 3;
    return (left.d2 - right.d2).norm() * scale * scale > allowed ? 2 : 1;
}

double size_of(const PiecewiseCubic& curve) {
    Vec2 low = curve.pieces().front()[0], high = low;
    for (std::size_t k = 0; k < curve.spans(); ++k) {
        const Vec2 end = curve.jet_in(k, curve.breaks()[k + 1]).position;
        low = low.cwiseMin(end).cwiseMin(curve.pieces()[k][0]);
        high = high.cwiseMax(end).cwiseMax(curve.pieces()[k][0]);
    }
    return (high - low).norm();
}

/// A knot and the piece that begins there.
struct Knot {
    double t;
    std::size_t piece;
};

}  // namespace

core::Result<BSpline<2>> to_bspline(const PiecewiseCubic& curve, double tolerance) {
    const std::size_t spans = curve.spans();
    if (spans == 0) return core::fail(ErrorCode::fit_not_evaluable, "B-spline: the curve has no pieces");
    const auto& breaks = curve.breaks();
    const bool closed = curve.closed();
    const double allowed = tolerance * size_of(curve), period = curve.period();
    std::vector<Knot> base;
    for (std::size_t k = 0; k < spans; ++k) {
        std::size_t times = 4;
        if (k > 0 || closed) {
            times = multiplicity(curve, (k + spans - 1) % spans, k, allowed);
            if (times == 4)
                return core::fail(ErrorCode::fit_not_evaluable,
                                  "B-spline: the curve jumps at break " + std::to_string(k));
        }
        base.insert(base.end(), times, {breaks[k], k});
    }
    std::vector<Knot> knots;
    if (closed && base.size() < 4) return core::fail(ErrorCode::fit_not_evaluable, "B-spline: needs 4 controls");
    if (closed)
        for (std::size_t j = base.size() - 3; j < base.size(); ++j)
            knots.push_back({base[j].t - period, base[j].piece});
    knots.insert(knots.end(), base.begin(), base.end());
    for (std::size_t j = 0; j < 4; ++j)
        knots.push_back(closed ? Knot{base[j].t + period, base[j].piece} : Knot{breaks.back(), spans - 1});

    std::vector<Vec2> controls(base.size());
    for (std::size_t j = 0; j < controls.size(); ++j) {
        std::size_t k = j + 1;  // a span of the support that is not empty, from its middle outwards
        for (const std::size_t candidate : {j + 2, j + 1, j + 3, j})
            if (knots[candidate].t < knots[candidate + 1].t) {
                k = candidate;
                break;
            }
        const double origin = knots[k].t;
        controls[j] = polar_form(curve.pieces()[knots[k].piece], knots[j + 1].t - origin, knots[j + 2].t - origin,
                                 knots[j + 3].t - origin);
    }
    std::vector<double> values;
    for (const Knot& knot : knots)
        values.push_back(knot.t);
    return BSpline<2>::make(3, std::move(values), std::move(controls), closed);
}

core::Result<PiecewiseCubic> to_piecewise(const BSpline<2>& curve) {
    if (curve.degree() != 3) return core::fail(ErrorCode::fit_not_evaluable, "B-spline: not cubic");
    const auto& knots = curve.knots();
    const auto& controls = curve.controls();
    std::vector<double> breaks;
    std::vector<PiecewiseCubic::Piece> pieces;
    for (std::size_t k = 3; k + 4 < knots.size(); ++k) {
        if (!(knots[k] < knots[k + 1])) continue;
        breaks.push_back(knots[k]);
        pieces.push_back(
            cubic_piece(cubic_basis(&knots[k - 2]), knots[k + 1] - knots[k],
                        [&](std::size_t a) -> const Vec2& { return controls[(k - 3 + a) % controls.size()]; }));
    }
    breaks.push_back(curve.back());
    return PiecewiseCubic(std::move(breaks), std::move(pieces), curve.closed());
}

}  // namespace cmm::fitting
