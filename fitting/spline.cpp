// SPDX-License-Identifier: Apache-2.0
#include "fitting/spline.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/cyclic.hpp"

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

PiecewiseCubic PiecewiseCubic::broken_at(std::span<const double> places) const {
    std::vector<double> breaks;
    std::vector<Piece> pieces;
    breaks.reserve(breaks_.size() + places.size());
    pieces.reserve(pieces_.size() + places.size());
    auto next = places.begin();
    for (std::size_t k = 0; k < pieces_.size(); ++k) {
        breaks.push_back(breaks_[k]);
        pieces.push_back(pieces_[k]);
        const auto& [a, b, c, d] = pieces_[k];
        for (; next != places.end() && *next < breaks_[k + 1]; ++next) {
            const double u = *next - breaks_[k];
            breaks.push_back(*next);
            pieces.push_back({a + u * (b + u * (c + u * d)), b + u * (2.0 * c + 3.0 * u * d), c + 3.0 * u * d, d});
        }
    }
    breaks.push_back(breaks_.back());
    return {std::move(breaks), std::move(pieces), closed_};
}

Vec2 PiecewiseCubic::blossom(double a, double b, double c, std::size_t near) const {
    double t = b;
    const std::size_t span = span_of(t, near);
    const double v = t - breaks_[span], u = v + a - b, w = v + c - b;
    const auto& [c0, c1, c2, c3] = pieces_[span];
    return c0 + (u + v + w) / 3.0 * c1 + (u * v + u * w + v * w) / 3.0 * c2 + u * v * w * c3;
}

std::vector<double> chord_parameters(std::span<const Vec2> points, bool closed) {
    std::vector<double> t(points.size() + (closed ? 1 : 0), 0.0);
    for (std::size_t i = 1; i < t.size(); ++i)
        t[i] = t[i - 1] + (points[cyclic(i, points.size())] - points[i - 1]).norm();
    return t;
}

namespace {

/// Pieces from values and second derivatives at the breaks.
std::vector<PiecewiseCubic::Piece> pieces_from(std::span<const Vec2> points, const std::vector<double>& t,
                                               const std::vector<Vec2>& second) {
    std::vector<PiecewiseCubic::Piece> pieces(t.size() - 1);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        const std::size_t next = cyclic(k + 1, points.size());
        const double h = t[k + 1] - t[k];
        pieces[k] = {points[k], (points[next] - points[k]) / h - h / 6.0 * (2.0 * second[k] + second[next]),
                     0.5 * second[k], (second[next] - second[k]) / (6.0 * h)};
    }
    return pieces;
}

}  // namespace

PeriodicInterpolation::PeriodicInterpolation(std::vector<double> parameters)
    : parameters_(std::move(parameters)), second_(parameters_.size() - 1, true) {
    const std::size_t n = second_.size();
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = cyclic(k + 1, n);
        const double h = width(k);
        second_.add(k, k, h / 3.0);
        second_.add(next, next, h / 3.0);
        second_.add(k, next, h / 6.0);
    }
    second_.factor();  // diagonally dominant: cannot fail
}

std::vector<Vec2> PeriodicInterpolation::second_derivatives(std::span<const Vec2> points) const {
    const std::size_t n = points.size();
    std::vector<Vec2> second(n, Vec2::Zero());
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t next = k + 1 < n ? k + 1 : 0;
        const Vec2 slope = (points[next] - points[k]) / width(k);
        second[k] += slope;
        second[next] -= slope;
    }
    second_.solve(std::span(second));
    return second;
}

PiecewiseCubic PeriodicInterpolation::through(std::span<const Vec2> points) const {
    return {parameters_, pieces_from(points, parameters_, second_derivatives(points)), true};
}

std::vector<Vec2> PeriodicInterpolation::controls(std::span<const Vec2> points) const {
    const std::size_t n = points.size();
    const auto second = second_derivatives(points);
    std::vector<Vec2> controls(n);
    double before = width(n - 1);
    for (std::size_t k = 0; k < n; ++k) {
        // The blossom of the piece behind point k at -before, 0, h from there (Ramshaw 1987).
        const std::size_t next = k + 1 < n ? k + 1 : 0;
        const double h = width(k);
        const Vec2 slope = (points[next] - points[k]) / h - h / 6.0 * (2.0 * second[k] + second[next]);
        controls[next] = points[k] + (h - before) / 3.0 * slope - before * h / 6.0 * second[k];
        before = h;
    }
    return controls;
}

PiecewiseCubic interpolate_periodic(std::span<const Vec2> points, std::vector<double> parameters) {
    return PeriodicInterpolation(std::move(parameters)).through(points);
}

namespace {

/// Row of a tridiagonal system: before x_{i-1} + at x_i + after x_{i+1} = right.
struct Row {
    double before = 0.0, at = 0.0, after = 0.0;
    Vec2 right = Vec2::Zero();
};

/// Gaussian elimination without pivoting: the rows are diagonally dominant.
std::vector<Vec2> solve_tridiagonal(std::vector<Row>& rows) {
    const std::size_t n = rows.size();
    for (std::size_t i = 1; i < n; ++i) {
        const double factor = rows[i].before / rows[i - 1].at;
        rows[i].at -= factor * rows[i - 1].after;
        rows[i].right -= factor * rows[i - 1].right;
    }
    std::vector<Vec2> x(n);
    for (std::size_t i = n; i-- > 0;)
        x[i] = (i + 1 < n ? Vec2(rows[i].right - rows[i].after * x[i + 1]) : rows[i].right) / rows[i].at;
    return x;
}

using Kind = SplineEnd::Kind;

/// Too few points for not-a-knot: the end gets the derivative of the polynomial of lowest degree. `slope` is that of
/// the chord at this end, `next` of the one after it, `share` the part that the end's interval has of both.
SplineEnd settled(const SplineEnd& end, const SplineEnd& other, std::size_t points, const Vec2& slope, const Vec2& next,
                  double share) {
    if (end.kind != Kind::not_a_knot || points > 3) return end;
    if (points == 3) return other.kind == end.kind ? SplineEnd::derivative(slope - share * (next - slope)) : end;
    return other.kind == Kind::derivative ? SplineEnd::derivative(2.0 * slope - other.value) : SplineEnd();
}

}  // namespace

PiecewiseCubic interpolate_open(std::span<const Vec2> points, std::vector<double> parameters, const SplineEnd& start,
                                const SplineEnd& end) {
    const std::size_t n = points.size();
    const auto width = [&](std::size_t k) { return parameters[k + 1] - parameters[k]; };
    const auto slope = [&](std::size_t k) { return Vec2((points[k + 1] - points[k]) / width(k)); };
    const double h = width(0), h_next = n > 2 ? width(1) : h, g = width(n - 2), g_next = n > 2 ? width(n - 3) : g;
    const SplineEnd first = settled(start, end, n, slope(0), slope(n > 2 ? 1 : 0), h / (h + h_next));
    const SplineEnd last = settled(end, start, n, slope(n - 2), slope(n > 2 ? n - 3 : 0), g / (g + g_next));

    std::vector<Row> rows(n);  // of the second derivatives
    for (std::size_t i = 1; i + 1 < n; ++i)
        rows[i] = {width(i - 1) / 6.0, (width(i - 1) + width(i)) / 3.0, width(i) / 6.0, slope(i) - slope(i - 1)};
    rows[0] = {0.0, 1.0, 0.0, Vec2::Zero()};
    rows[n - 1] = rows[0];
    if (first.kind == Kind::derivative) rows[0] = {0.0, h / 3.0, h / 6.0, slope(0) - first.value};
    if (last.kind == Kind::derivative) rows[n - 1] = {g / 6.0, g / 3.0, 0.0, last.value - slope(n - 2)};
    // Not a knot: M_0 = (1 + r) M_1 - r M_2 with r = h_0/h_1 goes into row 1; M_0 itself follows afterwards.
    if (first.kind == Kind::not_a_knot) {
        rows[1].at += (1.0 + h / h_next) * rows[1].before;
        rows[1].after -= h / h_next * rows[1].before;
        rows[1].before = 0.0;
    }
    if (last.kind == Kind::not_a_knot) {
        rows[n - 2].at += (1.0 + g / g_next) * rows[n - 2].after;
        rows[n - 2].before -= g / g_next * rows[n - 2].after;
        rows[n - 2].after = 0.0;
    }
    std::vector<Vec2> second = solve_tridiagonal(rows);
    if (first.kind == Kind::not_a_knot) second[0] = second[1] + h / h_next * (second[1] - second[2]);
    if (last.kind == Kind::not_a_knot) second[n - 1] = second[n - 2] + g / g_next * (second[n - 2] - second[n - 3]);
    auto pieces = pieces_from(points, parameters, second);
    return {std::move(parameters), std::move(pieces), false};
}

}  // namespace cmm::fitting
