// SPDX-License-Identifier: Apache-2.0
#include "fitting/least_squares.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

/// Four lanes of a vector register. GCC 12 takes a lane of an Eigen array by way of memory.
using Four = double __attribute__((vector_size(32)));

/// Over points of one span: sums of b b^T and b p^T, where b holds the four basis values. All stay in registers.
struct SpanSums {
    std::array<Four, 4> gram;
    Four x, y;

    void add(const Four& b, const Four& heavy, double px, double py) {
        for (std::size_t a = 0; a < 4; ++a)
            gram[a] += heavy[a] * b;
        x += px * heavy;
        y += py * heavy;
    }
};

template <bool Weighted>
SpanSums sum_span(const CubicBasis& basis, double origin, double inverse_width, std::size_t count, const double* t,
                  const double* x, const double* y, [[maybe_unused]] const double* weight) {
    std::array<Four, 4> power;
    static_assert(sizeof power == sizeof basis.power);
    std::memcpy(&power, &basis.power, sizeof power);
    SpanSums sums{};
    for (std::size_t i = 0; i < count; ++i) {
        const double w = (t[i] - origin) * inverse_width;
        const Four b = power[0] + w * (power[1] + w * (power[2] + w * power[3]));
        if constexpr (Weighted)
            sums.add(b, weight[i] * b, x[i], y[i]);
        else
            sums.add(b, b, x[i], y[i]);
    }
    return sums;
}

}  // namespace

core::Status LeastSquaresSpline::set_knots(std::span<const double> breaks, bool closed) {
    const std::size_t spans = breaks.empty() ? 0 : breaks.size() - 1;
    if (spans < (closed ? 7U : 1U))
        return core::fail(ErrorCode::fit_not_evaluable,
                          "least-squares spline: too few knots (" + std::to_string(breaks.size()) + ")");
    for (std::size_t k = 0; k < spans; ++k)
        if (!(breaks[k] < breaks[k + 1]))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "least-squares spline: knot " + std::to_string(k + 1) + " does not ascend");
    closed_ = closed;
    knots_.resize(spans + 7);
    std::copy(breaks.begin(), breaks.end(), knots_.begin() + 3);
    const double period = breaks.back() - breaks.front();
    for (std::size_t k = 0; k < 3; ++k) {
        knots_[k] = closed ? breaks[spans - 3 + k] - period : breaks.front();
        knots_[spans + 4 + k] = closed ? breaks[k + 1] + period : breaks.back();
    }
    bases_.resize(spans);
    for (std::size_t k = 0; k < spans; ++k)
        bases_[k] = cubic_basis(&knots_[k + 1]);
    const std::size_t controls = closed ? spans : spans + 3;
    normal_.reset(controls, closed);
    controls_.assign(controls, Vec2::Zero());
    first_.assign(spans + 1, 0);
    return {};
}

core::Status LeastSquaresSpline::add(const PointColumns& points, std::span<const double> weights) {
    const std::size_t n = points.t.size(), count = spans(), controls = controls_.size();
    if (points.x.size() != n || points.y.size() != n || (!weights.empty() && weights.size() != n))
        return core::fail(ErrorCode::fit_not_evaluable, "least-squares spline: columns of different length");
    std::size_t at = 0;
    double last = break_at(0);
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t from = at;
        const double end = break_at(k + 1);
        const bool final_span = k + 1 == count;
        for (; at < n && points.t[at] >= last && (points.t[at] < end || (final_span && points.t[at] == end)); ++at)
            last = points.t[at];
        first_[k] = from;
        const double origin = break_at(k), inverse_width = 1.0 / (end - origin);
        const double *t = points.t.data() + from, *x = points.x.data() + from, *y = points.y.data() + from;
        const SpanSums sums =
            weights.empty()
                ? sum_span<false>(bases_[k], origin, inverse_width, at - from, t, x, y, nullptr)
                : sum_span<true>(bases_[k], origin, inverse_width, at - from, t, x, y, weights.data() + from);
        normal_.add_block(k, sums.gram);
        for (std::size_t a = 0; a < 4; ++a)
            controls_[k + a < controls ? k + a : k + a - controls] += Vec2(sums.x[a], sums.y[a]);
    }
    first_[count] = n;
    if (at < n)
        return core::fail(ErrorCode::fit_not_evaluable, "least-squares spline: the parameter of point " +
                                                            std::to_string(at) + " is out of order or out of range");
    return {};
}

core::Status LeastSquaresSpline::solve() {
    if (!normal_.factor())
        return core::fail(ErrorCode::fit_not_evaluable, "least-squares spline: a span without enough points");
    normal_.solve(std::span(controls_));
    for (const Vec2& control : controls_)
        if (!is_finite(control))
            return core::fail(ErrorCode::fit_not_evaluable, "least-squares spline: values that are not finite");
    return {};
}

PiecewiseCubic LeastSquaresSpline::curve() const {
    const std::size_t count = spans(), controls = controls_.size();
    std::vector<PiecewiseCubic::Piece> pieces(count);
    for (std::size_t k = 0; k < count; ++k)
        pieces[k] = cubic_piece(bases_[k], break_at(k + 1) - break_at(k), [&](std::size_t a) -> const Vec2& {
            return controls_[k + a < controls ? k + a : k + a - controls];
        });
    return {std::vector<double>(knots_.begin() + 3, knots_.end() - 3), std::move(pieces), closed_};
}

core::Result<PiecewiseCubic> fit_fixed_knots(const PointColumns& points, std::span<const double> breaks, bool closed) {
    LeastSquaresSpline fit;
    if (auto status = fit.set_knots(breaks, closed); !status) return tl::unexpected(status.error());
    if (auto status = fit.add(points); !status) return tl::unexpected(status.error());
    if (auto status = fit.solve(); !status) return tl::unexpected(status.error());
    return fit.curve();
}

}  // namespace cmm::fitting
