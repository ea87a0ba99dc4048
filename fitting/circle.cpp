// SPDX-License-Identifier: Apache-2.0
#include "fitting/circle.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Cholesky>

#include "core/text.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double last_step = 1e-6;  // of the radius: Newton's next one would be its square

/// Grows from 0 to 4 with the polar angle of v, without a transcendental function.
double pseudo_angle(const Vec2& v) {
    const double r = v.x() / (std::abs(v.x()) + std::abs(v.y()));
    return v.y() >= 0.0 ? 1.0 - r : 3.0 + r;
}

/// The full turn less the largest gap between neighbouring polar angles.
double spanned_angle(std::span<const Vec2> points, const Vec2& centre) {
    struct Direction {
        double order;
        std::size_t index;
    };
    std::vector<Direction> around(points.size());
    for (std::size_t i = 0; i < points.size(); ++i)
        around[i] = {pseudo_angle(points[i] - centre), i};
    const auto before = [](const Direction& a, const Direction& b) { return a.order < b.order; };
    if (!std::is_sorted(around.begin(), around.end(), before)) std::sort(around.begin(), around.end(), before);
    // The pseudo angle grows by half to all of the angle (over 1 rad), so only gaps of half the widest can be it.
    double widest = around.front().order + 4.0 - around.back().order;
    for (std::size_t i = 1; i < around.size(); ++i)
        widest = std::max(widest, around[i].order - around[i - 1].order);
    double gap = 0.0;
    for (std::size_t i = 0; i < around.size(); ++i) {
        const Direction &from = around[i], &to = around[(i + 1) % around.size()];
        const double step = to.order - from.order + (i + 1 == around.size() ? 4.0 : 0.0);
        if (step < 0.499 * widest) continue;
        const double turn = turn_angle(points[from.index] - centre, points[to.index] - centre);
        gap = std::max(gap, turn < 0.0 ? turn + 2.0 * std::numbers::pi : turn);
    }
    return 2.0 * std::numbers::pi - gap;
}

using FourLanes = Eigen::Array4d;

/// Sums over the points, in four lanes or in one: a template, so that both say the same.
template <class Real>
struct Sums {
    Real xx, xy, x, y, xe, ye, e, ee, bend, bend_xx, bend_xy;

    explicit Sums(const Real& zero)
        : xx(zero),
          xy(zero),
          x(zero),
          y(zero),
          xe(zero),
          ye(zero),
          e(zero),
          ee(zero),
          bend(zero),
          bend_xx(zero),
          bend_xy(zero) {}

    /// A point relative to the centre.
    void add(const Real& dx, const Real& dy, double radius) {
        using std::sqrt;
        const Real distance = sqrt(dx * dx + dy * dy + 1e-30), inverse = 1.0 / distance;
        const Real ux = dx * inverse, uy = dy * inverse, residual = distance - radius, bending = residual * inverse;
        xx += ux * ux;
        xy += ux * uy;
        x += ux;
        y += uy;
        xe += ux * residual;
        ye += uy * residual;
        e += residual;
        ee += residual * residual;
        bend += bending;
        bend_xx += bending * ux * ux;
        bend_xy += bending * ux * uy;
    }
};

/// What a step towards the least squared orthogonal distances needs of the points, at one circle.
struct NormalEquations {
    Eigen::Matrix3d matrix;        // of Gauss-Newton
    Eigen::Matrix3d second_order;  // what Newton adds: residuals times their second derivatives
    Eigen::Vector3d rhs;
    double squares = 0.0;

    NormalEquations(std::span<const Vec2> points, const Eigen::Vector3d& circle) {
        const double cx = circle[0], cy = circle[1], radius = circle[2];
        const std::size_t n = points.size(), by_fours = n - n % 4;
        Sums<FourLanes> four(FourLanes::Zero());
        for (std::size_t i = 0; i < by_fours; i += 4) {
            const Vec2* p = &points[i];
            four.add(FourLanes(p[0].x(), p[1].x(), p[2].x(), p[3].x()) - cx,
                     FourLanes(p[0].y(), p[1].y(), p[2].y(), p[3].y()) - cy, radius);
        }
        Sums<double> one(0.0);
        for (std::size_t i = by_fours; i < n; ++i)
            one.add(points[i].x() - cx, points[i].y() - cy, radius);
        const double xx = one.xx + four.xx.sum(), xy = one.xy + four.xy.sum();
        const double x = one.x + four.x.sum(), y = one.y + four.y.sum(), count = static_cast<double>(n);
        const double bend = one.bend + four.bend.sum();
        const double bend_xx = one.bend_xx + four.bend_xx.sum(), bend_xy = one.bend_xy + four.bend_xy.sum();
        matrix << xx, xy, x, xy, count - xx, y, x, y, count;
        second_order << bend - bend_xx, -bend_xy, 0.0, -bend_xy, bend_xx, 0.0, 0.0, 0.0, 0.0;
        rhs << one.xe + four.xe.sum(), one.ye + four.ye.sum(), one.e + four.e.sum();
        squares = one.ee + four.ee.sum();
    }

    /// Newton's step, or that of Gauss and Newton where the sum of squares is not convex.
    Eigen::Vector3d step() const {
        const Eigen::LDLT<Eigen::Matrix3d> newton(matrix + second_order);
        if (newton.vectorD().minCoeff() > 0.0) return newton.solve(rhs);
        return matrix.ldlt().solve(rhs);
    }
};

/// Kasa's circle without the angle that the points span.
core::Result<Circle> algebraic_circle(std::span<const Vec2> points) {
    if (points.size() < 3) return core::fail(ErrorCode::fit_not_evaluable, "circle: fewer than 3 points");
    const double n = static_cast<double>(points.size());
    Vec2 mean = Vec2::Zero();
    for (const Vec2& p : points)
        mean += p;
    mean /= n;
    double largest = 0.0;
    for (const Vec2& p : points)
        largest = std::max(largest, (p - mean).squaredNorm());
    const double scale = std::sqrt(largest);
    if (!(scale > 0.0) || !std::isfinite(scale))
        return core::fail(ErrorCode::fit_not_evaluable, "circle: all points are equal");
    // Centred and scaled, because eq 5's system is badly conditioned far from the origin; the sums of x and y vanish.
    double xx = 0.0, xy = 0.0, yy = 0.0, xz = 0.0, yz = 0.0, z = 0.0;
    const double inverse = 1.0 / scale;
    for (const Vec2& p : points) {
        const double x = (p.x() - mean.x()) * inverse, y = (p.y() - mean.y()) * inverse, square = x * x + y * y;
        xx += x * x;
        xy += x * y;
        yy += y * y;
        xz += x * square;
        yz += y * square;
        z += square;
    }
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 1e-12 * (xx + yy) * (xx + yy)))
        return core::fail(ErrorCode::fit_not_evaluable, "circle: the points are on a line");
    const Vec2 centre = Vec2(yy * xz - xy * yz, xx * yz - xy * xz) / (2.0 * determinant);
    Circle circle;
    circle.centre = mean + scale * centre;
    circle.radius = scale * std::sqrt(centre.squaredNorm() + z / n);
    return circle;
}

}  // namespace

core::Result<Circle> fit_circle_kasa(std::span<const Vec2> points) {
    auto circle = algebraic_circle(points);
    if (circle) circle->arc_angle = spanned_angle(points, circle->centre);
    return circle;
}

core::Result<Circle> fit_circle(std::span<const Vec2> points, const Noise& known) {
    if (points.size() < 5)
        return core::fail(ErrorCode::fit_not_evaluable, "circle: needs 5 points, got " + std::to_string(points.size()));
    const auto start = algebraic_circle(points);
    if (!start) return start;
    Eigen::Vector3d circle(start->centre.x(), start->centre.y(), start->radius);
    NormalEquations now(points, circle);
    bool converged = false;
    for (int round = 0; round < 50 && !converged; ++round) {
        const Eigen::Vector3d step = now.step();
        converged = step.norm() < last_step * circle[2];
        if (converged) {
            circle += step;
            now.squares = std::max(0.0, now.squares - now.rhs.dot(step));
            break;
        }
        double share = 1.0;
        NormalEquations next(points, circle + step);
        while (!(next.squares <= now.squares) && share > 1e-6) {
            share *= 0.5;
            next = NormalEquations(points, circle + share * step);
        }
        circle += share * step;
        now = next;
    }
    if (!converged || !circle.allFinite()) return core::fail(ErrorCode::fit_not_evaluable, "circle: no convergence");

    Circle result;
    result.centre = circle.head<2>();
    result.radius = circle[2];
    const double freedom = static_cast<double>(points.size() - 3);
    result.rms = std::sqrt(now.squares / freedom);
    result.arc_angle = spanned_angle(points, result.centre);
    if (result.arc_angle < shortest_arc_rad)
        return core::fail(ErrorCode::fit_not_evaluable,
                          "circle: an arc of " + core::fixed(result.arc_angle * 180.0 / std::numbers::pi, 0) +
                              " degrees is too short for a radius (60 degrees)");
    result.noise = combined_noise(now.squares, freedom, known);
    result.covariance =
        result.noise.sigma_mm * result.noise.sigma_mm * now.matrix.ldlt().solve(Eigen::Matrix3d::Identity());
    result.radius_u95 = coverage_95(result.noise.freedom) * std::sqrt(result.covariance(2, 2));
    return result;
}

}  // namespace cmm::fitting
