// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "fitting/band_solver.hpp"
#include "fitting/vec2.hpp"

namespace cmm::fitting {

/// A point of a parametric curve with its first two derivatives by the parameter.
struct Jet {
    Vec2 position = Vec2::Zero();
    Vec2 d1 = Vec2::Zero();
    Vec2 d2 = Vec2::Zero();

    double speed() const { return d1.norm(); }
    Vec2 tangent() const { return d1.normalized(); }
    Vec2 right_normal() const { return fitting::right_normal(d1).normalized(); }
    /// Positive when the curve turns left: convex parts of a counter-clockwise section.
    double curvature() const {
        const double v = d1.norm();
        return v > 0.0 ? cross(d1, d2) / (v * v * v) : 0.0;
    }
};

/// A plane curve of cubic pieces: breaks t_0 < ... < t_K, on piece k a + b u + c u^2 + d u^3 with u = t - t_k.
/// Closed curves take any parameter (period t_K - t_0); open ones continue their end pieces. Immutable value, any
/// thread.
class PiecewiseCubic {
  public:
    using Piece = std::array<Vec2, 4>;

    PiecewiseCubic() = default;
    PiecewiseCubic(std::vector<double> breaks, std::vector<Piece> pieces, bool closed);

    Jet jet(double t) const {
        const std::size_t span = span_of(t);
        return jet_in(span, t);
    }
    /// The piece that holds t, which is first brought into the period; `near` is where the search begins.
    std::size_t span_of(double& t, std::size_t near) const;
    std::size_t span_of(double& t) const { return span_of(t, pieces_.size() / 2); }
    /// t inside the period already, span known.
    Jet jet_in(std::size_t span, double t) const;
    double wrap(double t) const;
    /// Round a closed curve from one parameter of the period on to another: 0 to the period.
    double ahead(double from, double to) const { return to >= from ? to - from : to - from + period(); }
    /// The polar form of the piece that holds b, at a <= b <= c: where these are neighbouring knots, the control point
    /// of a cubic spline between them (Ramshaw 1987). `near`: where the search for the piece begins.
    Vec2 blossom(double a, double b, double c, std::size_t near = 0) const;

    std::size_t spans() const { return pieces_.size(); }
    const std::vector<double>& breaks() const { return breaks_; }
    const std::vector<Piece>& pieces() const { return pieces_; }
    double front() const { return breaks_.front(); }
    double period() const { return breaks_.back() - breaks_.front(); }
    bool closed() const { return closed_; }
    /// The same curve with these breaks besides, ascending and each inside a span.
    PiecewiseCubic broken_at(std::span<const double> places) const;

  private:
    std::vector<double> breaks_;
    std::vector<Piece> pieces_;
    bool closed_ = false;
};

/// Cumulative chord length (seed 000, eq 8, with its sum bound corrected): t_0 = 0, n entries, n + 1 when closed.
std::vector<double> chord_parameters(std::span<const Vec2> points, bool closed);

/// The periodic C2 cubic splines through points at given parameters, one more than there are points (the period's end).
/// At least 3 points and strictly increasing parameters (checked by the callers). O(n) once, and for each spline.
class PeriodicInterpolation {
  public:
    explicit PeriodicInterpolation(std::vector<double> parameters);
    PiecewiseCubic through(std::span<const Vec2> points) const;
    /// The same spline's control points: number k belongs to the parameters k - 2, k - 1, k, round the end.
    std::vector<Vec2> controls(std::span<const Vec2> points) const;

  private:
    std::vector<Vec2> second_derivatives(std::span<const Vec2> points) const;
    double width(std::size_t k) const { return parameters_[k + 1] - parameters_[k]; }

    std::vector<double> parameters_;
    BandSolver<1> second_;  // of the second derivatives
};

/// One of them.
PiecewiseCubic interpolate_periodic(std::span<const Vec2> points, std::vector<double> parameters);

/// How an open spline ends: second derivative zero, a given first derivative, or not a knot (the third derivative does
/// not jump at the first inner point, so that the end pieces are one cubic; de Boor 1978).
struct SplineEnd {
    enum class Kind : std::uint8_t { natural, derivative, not_a_knot } kind = Kind::natural;
    Vec2 value = Vec2::Zero();  ///< the first derivative where it is given

    static SplineEnd derivative(const Vec2& value) { return {Kind::derivative, value}; }
    static SplineEnd not_a_knot() { return {Kind::not_a_knot, Vec2::Zero()}; }
};

/// The open C2 cubic spline through at least 2 points. Where there are too few points for not-a-knot the spline has
/// the lowest degree that fits (two points, both ends: a line; three: a parabola).
PiecewiseCubic interpolate_open(std::span<const Vec2> points, std::vector<double> parameters,
                                const SplineEnd& start = {}, const SplineEnd& end = {});

}  // namespace cmm::fitting
