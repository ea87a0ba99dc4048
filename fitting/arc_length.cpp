// SPDX-License-Identifier: Apache-2.0
#include "fitting/arc_length.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace cmm::fitting {
namespace {

constexpr double agreement = 1e-13;  // of all spans together
constexpr int most_bisections = 12;

using Eight = Eigen::Array<double, 8, 1>;
constexpr std::array<double, 8> gauss_nodes{0.019855071751231884, 0.10166676129318663, 0.23723379504183551,
                                            0.40828267875217511,  0.59171732124782489, 0.76276620495816449,
                                            0.89833323870681337,  0.98014492824876812};
constexpr std::array<double, 8> gauss_weights{0.050614268145188129, 0.11119051722668724, 0.15685332293894363,
                                              0.18134189168918099,  0.18134189168918099, 0.15685332293894363,
                                              0.11119051722668724,  0.050614268145188129};

/// Integral of the speed of piece `p` over [from, from + h] (from its own start): Gauss-Legendre, eight points.
double gauss(const PiecewiseCubic::Piece& p, double from, double h) {
    const Eight u = from + h * Eigen::Map<const Eight>(gauss_nodes.data());
    const Eight x = p[1].x() + u * (2.0 * p[2].x() + 3.0 * p[3].x() * u);
    const Eight y = p[1].y() + u * (2.0 * p[2].y() + 3.0 * p[3].y() * u);
    return h * (Eigen::Map<const Eight>(gauss_weights.data()) * (x * x + y * y).sqrt()).sum();
}

/// Halvings that a span needs for the agreement; `whole` is its length by one cell.
int halvings_for(const PiecewiseCubic::Piece& p, double h, double whole, double tolerance) {
    for (int depth = 0; depth < most_bisections; ++depth) {
        const auto cells = static_cast<double>(1 << depth);
        double difference = 0.0;
        for (int i = 0; i < 1 << depth; ++i) {
            const double from = i * h / cells, half = 0.5 * h / cells;
            const double cell = depth == 0 ? whole : gauss(p, from, 2.0 * half);
            difference += std::abs(cell - gauss(p, from, half) - gauss(p, from + half, half));
        }
        if (!(difference > tolerance)) return depth;
    }
    return most_bisections;
}

double slowness(const Jet& jet) {
    const double v = jet.speed();
    return v > 0.0 ? 1.0 / v : 0.0;
}

}  // namespace

ArcLength::ArcLength(const PiecewiseCubic& curve) {
    const std::size_t spans = curve.spans();
    if (spans == 0) return;
    const auto& breaks = curve.breaks();
    std::vector<double> whole(spans);
    double rough = 0.0;
    for (std::size_t k = 0; k < spans; ++k)
        rough += whole[k] = gauss(curve.pieces()[k], 0.0, breaks[k + 1] - breaks[k]);
    const double tolerance = agreement * rough / static_cast<double>(spans);
    double s = 0.0;
    first_cell_.reserve(spans + 1);
    cells_.reserve(spans + 1);
    for (std::size_t k = 0; k < spans; ++k) {
        const double h = breaks[k + 1] - breaks[k];
        const int count = 1 << halvings_for(curve.pieces()[k], h, whole[k], tolerance);
        first_cell_.push_back(cells_.size());
        for (int i = 0; i < count; ++i) {
            const double from = i * h / count, to = (i + 1) * h / count;
            cells_.push_back({breaks[k] + from, s, slowness(curve.jet_in(k, breaks[k] + from)),
                              slowness(curve.jet_in(k, breaks[k] + to)), k});
            s += count == 1 ? whole[k] : gauss(curve.pieces()[k], from, to - from);
        }
    }
    first_cell_.push_back(cells_.size());
    cells_.push_back({breaks.back(), s, 0.0, 0.0, spans});
    cells_.shrink_to_fit();
    const std::size_t buckets = cells_.size();
    buckets_per_mm_ = static_cast<double>(buckets) / s;
    bucket_.reserve(buckets + 1);
    for (std::size_t i = 0, cell = 0; i <= buckets; ++i) {
        while (cell + 2 < cells_.size() && cells_[cell + 1].s * buckets_per_mm_ <= static_cast<double>(i))
            ++cell;
        bucket_.push_back(cell);
    }
}

double ArcLength::at(const PiecewiseCubic& curve, const CurvePlace& place) const {
    const std::size_t first = first_cell_[place.span], end = first_cell_[place.span + 1];
    std::size_t cell = first;
    while (cell + 1 < end && cells_[cell + 1].t <= place.t)
        ++cell;
    const double origin = curve.breaks()[place.span], from = cells_[cell].t;
    return cells_[cell].s + gauss(curve.pieces()[place.span], from - origin, place.t - from);
}

std::size_t ArcLength::cell_of(double s_mm) const {
    const double last = static_cast<double>(bucket_.size() - 1);
    std::size_t cell = bucket_[static_cast<std::size_t>(std::max(0.0, std::min(last, s_mm * buckets_per_mm_)))];
    while (cell > 0 && cells_[cell].s > s_mm)
        --cell;
    while (cell + 2 < cells_.size() && cells_[cell + 1].s <= s_mm)
        ++cell;
    return cell;
}

/// Cubic Hermite of t over s.
CurvePlace ArcLength::place_within(std::size_t cell, double s_mm) const {
    const Cell &here = cells_[cell], &next = cells_[cell + 1];
    const double length = next.s - here.s, rise = next.t - here.t;
    if (!(length > 0.0)) return {here.span, here.t};
    const double x = std::clamp((s_mm - here.s) / length, 0.0, 1.0);
    const double a = here.slowness * length, b = here.slowness_end * length;
    const double t = here.t + x * (a + x * (3.0 * rise - 2.0 * a - b + x * (a + b - 2.0 * rise)));
    return {here.span, std::clamp(t, here.t, next.t)};
}

CurvePlace ArcLength::place_near(double s_mm) const {
    return place_within(cell_of(s_mm), s_mm);
}

CurvePlace ArcLength::place(const PiecewiseCubic& curve, double s_mm) const {
    const std::size_t cell = cell_of(s_mm);
    const double from = cells_[cell].t, to = cells_[cell + 1].t;
    const double length = cells_[cell + 1].s - cells_[cell].s, wanted = std::clamp(s_mm - cells_[cell].s, 0.0, length);
    auto [span, t] = place_within(cell, s_mm);
    if (!(length > 0.0)) return {span, t};
    // Newton's method with the second derivative.
    const double origin = curve.breaks()[span];
    for (int step = 0; step < 8; ++step) {
        const Jet jet = curve.jet_in(span, t);
        const double squared = jet.d1.squaredNorm();
        if (!(squared > 0.0)) break;
        const double missing = wanted - gauss(curve.pieces()[span], from - origin, t - from);
        const double newton = missing / std::sqrt(squared);
        const double correction = newton * (1.0 - 0.5 * newton * jet.d1.dot(jet.d2) / squared);
        t = std::clamp(t + correction, from, to);
        if (std::abs(correction) < 1e-4 * (to - from)) break;  // the step just made cubed this
    }
    return {span, t};
}

}  // namespace cmm::fitting
