// SPDX-License-Identifier: Apache-2.0
#include "fitting/parallel_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace cmm::fitting {
namespace {

constexpr double most_turn_rad = 1.5;
constexpr double corner_rad = 1e-9;     // a nanometre wide gap at 1 m: below it rounding, above it a corner
constexpr double least_loop_mm = 1e-9;  // a shorter step back is rounding
constexpr double least_share = 1e-10;   // of a piece: no stop of the parallel curve is located finer

/// Control vectors of c' over [from, to] of a piece (u from its beginning): the blossom of a quadratic.
using Hodograph = std::array<Vec2, 3>;

Hodograph hodograph(const PiecewiseCubic::Piece& piece, double from, double to) {
    const auto blossom = [&](double u, double v) -> Vec2 {
        return piece[1] + (u + v) * piece[2] + (3.0 * u * v) * piece[3];
    };
    return {blossom(from, from), blossom(from, to), blossom(to, to)};
}

/// Not less than the angle between two vectors, and hardly more where it is small.
double angle_bound(const Vec2& a, const Vec2& b) {
    const double along = a.dot(b), across = std::abs(cross(a, b));
    if (across < along) return across / along;
    return along == 0.0 && across == 0.0 ? std::numbers::pi : std::atan2(across, along);
}

double turn_bound(const Hodograph& h) {
    return angle_bound(h[0], h[1]) + angle_bound(h[1], h[2]);
}

/// Bezier coefficients over [from, to] of c' x c'' = 2 b x c + 6 b x d u + 6 c x d u^2 (the cubic term vanishes).
std::array<double, 3> bend_coefficients(const PiecewiseCubic::Piece& piece, double from, double to) {
    const double x0 = 2.0 * cross(piece[1], piece[2]), x1 = 6.0 * cross(piece[1], piece[3]),
                 x2 = 6.0 * cross(piece[2], piece[3]);
    const auto blossom = [&](double u, double v) { return x0 + 0.5 * x1 * (u + v) + x2 * u * v; };
    return {blossom(from, from), blossom(from, to), blossom(to, to)};
}

/// Sign of 1 + d kappa = (|c'|^3 + d c' x c'')/|c'|^3 over [from, to]; 0: not certain.
int direction_of(const PiecewiseCubic::Piece& piece, double from, double to, double distance) {
    const Hodograph h = hodograph(piece, from, to);
    const auto b = bend_coefficients(piece, from, to);
    const std::array<double, 3> wanted{-distance * b[0], -distance * b[1], -distance * b[2]};
    const double most = std::max({wanted[0], wanted[1], wanted[2]});
    // Bezier coefficients of |c'|^2, a quartic.
    const std::array<double, 5> speed{h[0].squaredNorm(), h[0].dot(h[1]),
                                      (h[0].dot(h[2]) + 2.0 * h[1].squaredNorm()) / 3.0, h[1].dot(h[2]),
                                      h[2].squaredNorm()};
    const double slow = std::min({speed[0], speed[1], speed[2], speed[3], speed[4]});
    if (slow > 0.0 && slow * std::sqrt(slow) > most) return 1;
    const double least = std::min({wanted[0], wanted[1], wanted[2]});
    const double fast = std::max({speed[0], speed[1], speed[2], speed[3], speed[4]});
    return fast * std::sqrt(fast) < least ? -1 : 0;
}

Vec2 unit_normal(const Vec2& tangent) {
    return right_normal(tangent) / tangent.norm();
}

void set_reach(Stretch& s) {
    s.reach = 0.5 * (s.end - s.begin).norm() * std::tan(0.5 * std::min(s.turn, 3.0));
}

}  // namespace

ParallelCurve::ParallelCurve(const PiecewiseCubic& source, double distance_mm)
    : source_(source), distance_(distance_mm) {
    const std::size_t n = source.spans();
    stretches_.reserve(n + 16);
    const auto& pieces = source.pieces();
    const auto& breaks = source.breaks();
    Vec2 before = source.jet_in(n - 1, breaks[n]).d1;
    for (std::size_t k = 0; k < n; ++k) {
        const Vec2& after = pieces[k][1];
        const double along = before.dot(after), across = cross(before, after);
        if (std::abs(across) > corner_rad * along) add_corner(k, before, after);
        add_piece(k);
        const double h = breaks[k + 1] - breaks[k];
        before = pieces[k][1] + h * (2.0 * pieces[k][2] + 3.0 * h * pieces[k][3]);
    }
}

void ParallelCurve::add_corner(std::size_t span, const Vec2& before, const Vec2& after) {
    const double sweep = turn_angle(before, after);
    const Vec2 normal = unit_normal(before);
    const double start = std::atan2(normal.y(), normal.x());
    const int parts = static_cast<int>(std::ceil(std::abs(sweep) / most_turn_rad));
    Stretch s;
    s.span = span;
    s.about_corner = true;
    s.backwards = distance_ * sweep < 0.0;
    s.left = sweep > 0.0;
    s.right = !s.left;
    for (int i = 0; i < parts; ++i)
        stretches_.push_back(part(s, start + sweep * i / parts, start + sweep * (i + 1) / parts));
    regular_ = regular_ && !s.backwards;
}

Stretch ParallelCurve::stretch_of(std::size_t span, double from, double to, bool backwards) const {
    const double origin = source_.breaks()[span];
    const auto& piece = source_.pieces()[span];
    const Hodograph h = hodograph(piece, from - origin, to - origin);
    const auto place = [&](double u) -> Vec2 { return piece[0] + u * (piece[1] + u * (piece[2] + u * piece[3])); };
    Stretch s;
    s.span = span;
    s.backwards = backwards;
    const auto bend = bend_coefficients(piece, from - origin, to - origin);
    s.left = std::min({bend[0], bend[1], bend[2]}) >= 0.0;
    s.right = std::max({bend[0], bend[1], bend[2]}) <= 0.0;
    s.from = from;
    s.to = to;
    s.turn = turn_bound(h);
    s.begin = place(from - origin) + distance_ * unit_normal(h[0]);
    s.end = place(to - origin) + distance_ * unit_normal(h[2]);
    set_reach(s);
    return s;
}

void ParallelCurve::add_piece(std::size_t span) {
    const double from = source_.breaks()[span], to = source_.breaks()[span + 1];
    if (const int direction = direction_of(source_.pieces()[span], 0.0, to - from, distance_); direction != 0)
        return add_part(span, from, to, direction < 0);
    std::vector<Run> runs;
    find_runs(span, from, to, runs);
    for (std::size_t i = 0; i < runs.size(); ++i)
        add_part(span, runs[i].from, i + 1 < runs.size() ? runs[i + 1].from : to, runs[i].backwards);
}

/// A piece may be so short that its parameter has no value between two of them.
bool ParallelCurve::can_halve(std::size_t span, double from, double to) const {
    const double width = source_.breaks()[span + 1] - source_.breaks()[span], middle = 0.5 * (from + to);
    return to - from > least_share * width && from < middle && middle < to;
}

/// Where the parallel curve stops and turns back, by bisection of what is not certain.
void ParallelCurve::find_runs(std::size_t span, double from, double to, std::vector<Run>& runs) const {
    const double origin = source_.breaks()[span], middle = 0.5 * (from + to);
    int direction = direction_of(source_.pieces()[span], from - origin, to - origin, distance_);
    if (direction == 0 && can_halve(span, from, to)) {
        find_runs(span, from, middle, runs);
        return find_runs(span, middle, to, runs);
    }
    if (direction == 0) direction = 1.0 + distance_ * source_.jet_in(span, middle).curvature() < 0.0 ? -1 : 1;
    if (runs.empty() || runs.back().backwards != (direction < 0)) runs.push_back({from, direction < 0});
}

void ParallelCurve::add_part(std::size_t span, double from, double to, bool backwards) {
    Stretch s = stretch_of(span, from, to, backwards);
    if (backwards && (s.end - s.begin).norm() + s.reach < least_loop_mm) s.backwards = backwards = false;
    if (s.turn > most_turn_rad && can_halve(span, from, to)) {
        add_part(span, from, 0.5 * (from + to), backwards);
        return add_part(span, 0.5 * (from + to), to, backwards);
    }
    stretches_.push_back(s);
    regular_ = regular_ && !backwards;
}

Stretch ParallelCurve::part(const Stretch& stretch, double from, double to) const {
    if (!stretch.about_corner) return stretch_of(stretch.span, from, to, stretch.backwards);
    Stretch s = stretch;
    s.from = from;
    s.to = to;
    s.turn = std::abs(to - from);
    s.begin = at(s, from).position;
    s.end = at(s, to).position;
    set_reach(s);
    return s;
}

OffsetPoint ParallelCurve::at(const Stretch& stretch, double x) const {
    if (stretch.about_corner) {
        const Vec2 normal(std::cos(x), std::sin(x));
        return {source_.pieces()[stretch.span][0] + distance_ * normal, normal, source_.breaks()[stretch.span], true};
    }
    const Jet jet = source_.jet_in(stretch.span, x);
    const Vec2 normal = unit_normal(jet.d1);
    return {jet.position + distance_ * normal, normal, x, false};
}

Vec2 ParallelCurve::derivative(const Stretch& stretch, double x) const {
    if (stretch.about_corner) return distance_ * Vec2(-std::sin(x), std::cos(x));
    const Jet jet = source_.jet_in(stretch.span, x);
    return (1.0 + distance_ * jet.curvature()) * jet.d1;
}

}  // namespace cmm::fitting
