// SPDX-License-Identifier: Apache-2.0
#include "fitting/curve_samples.hpp"

#include <Eigen/Core>
#include <cmath>

namespace cmm::fitting {
namespace {

void resize(CurveSamples& samples, std::size_t n) {
    for (auto* column : {&samples.t, &samples.x, &samples.y, &samples.dx, &samples.dy, &samples.ddx, &samples.ddy,
                         &samples.nx, &samples.ny, &samples.curvature})
        column->resize(n);
}

/// Points [from, to) of one span: value and derivatives of one coordinate.
void evaluate(const PiecewiseCubic::Piece& piece, Eigen::Index axis, double origin, std::size_t from, std::size_t to,
              const double* t, double* value, double* first, double* second) {
    const double a = piece[0][axis], b = piece[1][axis], c = piece[2][axis], d = piece[3][axis];
    for (std::size_t i = from; i < to; ++i) {
        const double u = t[i] - origin;
        value[i] = a + u * (b + u * (c + u * d));
        first[i] = b + u * (2.0 * c + 3.0 * u * d);
        second[i] = 2.0 * c + 6.0 * u * d;
    }
}

void evaluate_run(const PiecewiseCubic& curve, std::size_t span, std::size_t from, std::size_t to,
                  CurveSamples& samples) {
    const auto& piece = curve.pieces()[span];
    const double origin = curve.breaks()[span];
    evaluate(piece, 0, origin, from, to, samples.t.data(), samples.x.data(), samples.dx.data(), samples.ddx.data());
    evaluate(piece, 1, origin, from, to, samples.t.data(), samples.y.data(), samples.dy.data(), samples.ddy.data());
}

void normals_and_curvatures(CurveSamples& samples) {
    using Column = Eigen::Map<Eigen::ArrayXd>;
    const auto n = static_cast<Eigen::Index>(samples.size());
    const auto column = [n](std::vector<double>& values) { return Column(values.data(), n); };
    const auto dx = column(samples.dx), dy = column(samples.dy);
    auto nx = column(samples.nx), ny = column(samples.ny), curvature = column(samples.curvature);
    curvature = (dx * dx + dy * dy).sqrt();  // holds the speed until the normals are there
    curvature = (curvature > 0.0).select(curvature.inverse(), 0.0);
    nx = dy * curvature;
    ny = -dx * curvature;
    curvature = (dx * column(samples.ddy) - dy * column(samples.ddx)) * curvature * curvature * curvature;
}

}  // namespace

void sample_at(const PiecewiseCubic& curve, std::span<const double> t, CurveSamples& samples) {
    const std::size_t n = t.size();
    resize(samples, n);
    const auto& breaks = curve.breaks();
    std::size_t span = 0;
    for (std::size_t from = 0, to; from < n; from = to) {
        samples.t[from] = t[from];
        span = curve.span_of(samples.t[from], span);
        const double low = breaks[span], high = breaks[span + 1];
        for (to = from + 1; to < n && t[to] >= low && t[to] < high; ++to)
            samples.t[to] = t[to];
        evaluate_run(curve, span, from, to, samples);
    }
    normals_and_curvatures(samples);
}

void sample_along(const PiecewiseCubic& curve, const ArcLength& arc, std::span<const double> s_mm,
                  CurveSamples& samples) {
    const std::size_t n = s_mm.size();
    resize(samples, n);
    CurvePlace place, next;
    std::size_t from = 0;
    for (std::size_t i = 0; i < n; ++i) {
        next = arc.place(curve, s_mm[i]);
        samples.t[i] = next.t;
        if (next.span != place.span) {
            if (i > from) evaluate_run(curve, place.span, from, i, samples);
            from = i;
            place = next;
        }
    }
    if (n > 0) evaluate_run(curve, next.span, from, n, samples);
    normals_and_curvatures(samples);
}

}  // namespace cmm::fitting
