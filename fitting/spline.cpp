// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/band_solver.hpp"

namespace cmm::fitting {

PiecewiseCubic::PiecewiseCubic(std::vector<double> breaks, std::vector<Piece> pieces, bool closed)
    : breaks_(std::move(breaks)), pieces_(std::move(pieces)), closed_(closed) {}

double PiecewiseCubic::wrap(double t) const {
    if (!closed_ || (t >= breaks_.front() && t < breaks_.back())) return t;
    const double turns = std::floor((t - breaks_.front()) / period());
    return std::clamp(t - turns * period(), breaks_.front(), breaks_.back());
}

std::size_t PiecewiseCubic::span_of(double& t, std::size_t near) const {
    t = wrap(t);
    near = std::min(near, pieces_.size() - 1);
    if (t >= breaks_[near] && t < breaks_[near + 1]) return near;
    const auto above = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, t);
    return static_cast<std::size_t>(above - breaks_.begin()) - 1;
}

Jet PiecewiseCubic::jet_in(std::size_t span, double t) const {
    const double u = t - breaks_[span];
    const auto& [a, b, c, d] = pieces_[span];
    return {a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d), 2.0 * c + 6.0 * u * d};
}

std::vector<double> chord_parameters(std::span<const Vec2> points, bool closed) {
    std::vector<double> t(points.size() + (closed ? 1 : 0), 0.0);
    for (std::size_t i = 1; i < t.size(); ++i)
        t[i] = t[i - 1] + (points[i % points.size()] - points[i - 1]).norm();
    return t;
}

namespace {

/// Pieces from values and second derivatives at the breaks.
std::vector<PiecewiseCubic::Piece> pieces_from(std::span<const Vec2> points, const std::vector<double>& t,
                                               const std::vector<Vec2>& second) {
    std::vector<PiecewiseCubic::Piece> pieces(t.size() - 1);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const std::size_t next = (k + 1) % points.size();
        const double h = t[k + 1] - t[k];
        pieces[k] = {points[k], (points[next] - points[k]) / h - h / 6.0 * (2.0 * second[k] + second[next]),
                     0.5 * second[k], (second[next] - second[k]) / (6.0 * h)};
    }
    return pieces;
}

}  // namespace

PiecewiseCubic interpolate_periodic(std::span<const Vec2> points, std::vector<double> parameters) {
    const std::size_t n = points.size();
    BandSolver<1> system(n, true);
    std::vector<Vec2> second(n, Vec2::Zero());
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = (k + 1) % n;
        const double h = parameters[k + 1] - parameters[k];
        system.add(k, k, h / 3.0);
        system.add(next, next, h / 3.0);
        system.add(k, next, h / 6.0);
        const Vec2 slope = (points[next] - points[k]) / h;
        second[k] += slope;
        second[next] -= slope;
    }
    system.factor();  // diagonally dominant: cannot fail
    system.solve(std::span(second));
    auto pieces = pieces_from(points, parameters, second);
    return {std::move(parameters), std::move(pieces), true};
}

PiecewiseCubic interpolate_open(std::span<const Vec2> points, std::vector<double> parameters,
                                const std::optional<Vec2>& start_derivative,
                                const std::optional<Vec2>& end_derivative) {
    const std::size_t n = points.size();
    BandSolver<1> system(n, false);
    std::vector<Vec2> second(n, Vec2::Zero());
    for (std::size_t k = 0; k + 1 < n; ++k) {
        const double h = parameters[k + 1] - parameters[k];
        system.add(k, k, h / 3.0);
        system.add(k + 1, k + 1, h / 3.0);
        const bool natural_start = k == 0 && !start_derivative;
        const bool natural_end = k + 2 == n && !end_derivative;
        if (!natural_start && !natural_end) system.add(k, k + 1, h / 6.0);
        const Vec2 slope = (points[k + 1] - points[k]) / h;
        second[k] += slope;
        second[k + 1] -= slope;
    }
    // A natural end keeps its own row (decoupled above) with right-hand side zero: second derivative zero.
    second.front() = start_derivative ? Vec2(second.front() - *start_derivative) : Vec2::Zero();
    second.back() = end_derivative ? Vec2(second.back() + *end_derivative) : Vec2::Zero();
    system.factor();
    system.solve(std::span(second));
    auto pieces = pieces_from(points, parameters, second);
    return {std::move(parameters), std::move(pieces), false};
}

}  // namespace cmm::fitting
