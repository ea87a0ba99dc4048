// SPDX-License-Identifier: Apache-2.0
#include "fitting/edge_shapes.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/rng.hpp"
#include "fitting/orthogonal_fit.hpp"

namespace cmm::fitting {
namespace {

Vec2 unit(double angle) {
    return {std::cos(angle), std::sin(angle)};
}

template <class Shape>
Shape shape_of(std::initializer_list<double> values) {
    typename Shape::Values v;
    int k = 0;
    for (const double value : values)
        v[k++] = value;
    return Shape(v);
}

/// The foot is where the shape's normal points at p, and it moves along that normal by `slopes` when the shape changes.
template <class Shape>
void check_feet(const Shape& shape, double nose_direction) {
    for (double turn = -1.2; turn <= 1.2; turn += 0.1) {
        const Vec2 near = unit(nose_direction + turn);
        const auto on = shape.foot(Vec2(shape.values().template head<2>()) + 5.0 * near, near);
        for (const double off : {-0.02, 0.0, 0.3, 1.0, 4.0}) {
            const Vec2 p = on.position + off * on.normal;
            const auto foot = shape.foot(p, unit(nose_direction + turn + 0.2));
            // The iteration stops where the distance is exact; along the curve it may be a nanometre off.
            EXPECT_NEAR((p - foot.position).dot(foot.normal), off, 1e-11) << turn;
            EXPECT_LT((foot.position - on.position).norm(), 1e-6) << turn << ' ' << off;
            EXPECT_LT((foot.normal - on.normal).norm(), 1e-5);
            for (int k = 0; k < Shape::size; ++k) {
                const double h = 1e-6;
                auto more = shape.values(), less = more;
                more[k] += h;
                less[k] -= h;
                const auto a = Shape(more).foot(p, foot.normal), b = Shape(less).foot(p, foot.normal);
                const double slope = ((p - b.position).dot(b.normal) - (p - a.position).dot(a.normal)) / (2.0 * h);
                EXPECT_NEAR(foot.slopes[k], slope, 1e-6) << "parameter " << k << " at " << turn << ' ' << off;
            }
        }
        // Radius of curvature: way over turn.
        const Vec2 beside = (on.normal + 1e-3 * Vec2(on.normal.y(), -on.normal.x())).normalized();
        const auto a = shape.foot(on.position + beside, beside);
        const double turned = turn_angle(a.normal, on.normal), way = (on.position - a.position).norm();
        if (std::abs(turned) > 1e-6) {
            const double radius = 0.5 * (shape.radius_at(on.normal) + shape.radius_at(a.normal));
            EXPECT_NEAR(way / std::abs(turned), radius, 2e-3 * radius) << turn;
        }
    }
}

TEST(EdgeShapes, FeetAreOrthogonalAndSlopesAreDerivatives) {
    check_feet(shape_of<ArcShape>({3.0, -2.0, 0.4}), 0.5);
    check_feet(shape_of<EllipseShape>({3.0, -2.0, 0.5, 0.2, 0.25}), 0.5);
    check_feet(shape_of<EllipseShape>({3.0, -2.0, 2.5, 0.9, 2.5}), 2.5);
    check_feet(shape_of<EllipseShape>({3.0, -2.0, -1.0, 0.3, 1.0}), -1.0);
    check_feet(shape_of<ParabolaShape>({3.0, -2.0, -2.0, 0.3}), -2.0);
    // Off the place where the arcs meet: there the derivative by that place has a kink.
    check_feet(shape_of<DoubleArcShape>({3.0, -2.0, 0.3, 0.5, 1.43}), 1.4);
}

/// By the eccentric angle, with the semi-axes.
TEST(EdgeShapes, TheEllipseIsThatOfItsSemiAxes) {
    const double a = 0.8, b = 0.3, direction = 0.7;
    const auto ellipse = shape_of<EllipseShape>({1.0, 2.0, direction, b * b / a, b * b / (a * a)});
    EXPECT_NEAR(ellipse.semi_axis_along(), a, 1e-14);
    EXPECT_NEAR(ellipse.semi_axis_across(), b, 1e-14);
    const Vec2 axis = unit(direction), side(-axis.y(), axis.x()), centre = Vec2(1.0, 2.0) - a * axis;
    for (double e = -1.5; e <= 1.5; e += 0.1) {
        const Vec2 p = centre + a * std::cos(e) * axis + b * std::sin(e) * side;
        const Vec2 normal = (b * std::cos(e) * axis + a * std::sin(e) * side).normalized();
        const auto foot = ellipse.foot(p + 1.5 * normal, unit(direction + e));
        EXPECT_NEAR((p + 1.5 * normal - foot.position).dot(foot.normal), 1.5, 1e-11) << e;
        EXPECT_LT((foot.position - p).norm(), 1e-6) << e;
    }
}

template <class Shape>
std::vector<Vec2> centres_of(const Shape& shape, double nose, double half, std::size_t n, double ball, double sigma,
                             core::Rng& rng, std::vector<Vec2>& normals) {
    std::vector<Vec2> points;
    normals.clear();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 near = unit(nose + half * (2.0 * static_cast<double>(i) / static_cast<double>(n - 1) - 1.0));
        const auto foot = shape.foot(Vec2(shape.values().template head<2>()) + 3.0 * near, near);
        points.push_back(foot.position + (ball + sigma * rng.normal()) * foot.normal);
        normals.push_back((foot.normal + 0.02 * Vec2(rng.normal(), rng.normal())).normalized());
    }
    return points;
}

template <class Shape>
void check_side_by_side(const Shape& shape, double nose) {
    core::Rng rng(4);
    for (int trial = 0; trial < 200; ++trial) {
        std::vector<Vec2> points, near;
        for (int k = 0; k < foot_lanes; ++k) {
            near.push_back(unit(nose + 1.5 * rng.normal()));
            points.push_back(Vec2(shape.values().template head<2>()) + Vec2(rng.normal(), rng.normal()));
        }
        std::array<typename Shape::Foot, foot_lanes> feet;
        shape.feet(points.data(), near.data(), feet.data());
        for (std::size_t k = 0; k < feet.size(); ++k) {
            const auto alone = shape.foot(points[k], near[k]);
            ASSERT_EQ(feet[k].position, alone.position) << trial << ' ' << k;
            ASSERT_EQ(feet[k].normal, alone.normal) << trial << ' ' << k;
            ASSERT_EQ(feet[k].slopes, alone.slopes) << trial << ' ' << k;
        }
    }
}

/// Points far and near, inside and out, whose search takes from one to all steps.
TEST(EdgeShapes, SideBySideTheFeetAreTheSameToTheLastBit) {
    check_side_by_side(shape_of<EllipseShape>({3.0, -2.0, 0.5, 0.2, 0.25}), 0.5);
    check_side_by_side(shape_of<EllipseShape>({3.0, -2.0, 2.5, 0.9, 2.5}), 2.5);
    check_side_by_side(shape_of<EllipseShape>({3.0, -2.0, 2.5, 0.9, -0.2}), 2.5);
    check_side_by_side(shape_of<ParabolaShape>({3.0, -2.0, -2.0, 0.3}), -2.0);
}

/// From a start some per cent off: exact without noise, and with noise the scatter that the normal matrix says.
template <class Shape>
void check_fit(const Shape& truth, double nose) {
    core::Rng rng(17);
    std::vector<Vec2> normals;
    std::vector<double> residuals(72);
    typename Shape::Values off = truth.values();
    for (int k = 0; k < Shape::size; ++k)
        off[k] += (k % 2 == 0 ? 0.01 : -0.015);
    auto points = centres_of(truth, nose, 1.3, 72, 1.0, 0.0, rng, normals);
    const auto exact = fit_orthogonal<Shape>({points, normals, residuals, 1.0}, Shape(off));
    ASSERT_TRUE(exact.converged);
    EXPECT_LT((exact.shape.values() - truth.values()).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT(exact.squares, 1e-16);

    typename OrthogonalFit<Shape>::Matrix scatter = OrthogonalFit<Shape>::Matrix::Zero();
    constexpr int runs = 2000;
    for (int k = 0; k < runs; ++k) {
        points = centres_of(truth, nose, 1.3, 72, 1.0, 1e-3, rng, normals);
        const auto fit = fit_orthogonal<Shape>({points, normals, residuals, 1.0}, Shape(off));
        ASSERT_TRUE(fit.converged);
        const typename Shape::Values error = fit.shape.values() - truth.values();
        scatter += error * error.transpose() / runs;
    }
    const typename OrthogonalFit<Shape>::Matrix predicted = 1e-6 * inverse_of_small(exact.normal);
    for (int k = 0; k < Shape::size; ++k)
        EXPECT_NEAR(std::sqrt(scatter(k, k)), std::sqrt(predicted(k, k)), 0.08 * std::sqrt(predicted(k, k))) << k;
}

TEST(OrthogonalFit, FindsTheShapeWithTheScatterOfItsNormalMatrix) {
    check_fit(shape_of<ArcShape>({3.0, -2.0, 0.4}), 0.3);
    check_fit(shape_of<EllipseShape>({3.0, -2.0, 0.3, 0.15, 0.25}), 0.3);
    check_fit(shape_of<ParabolaShape>({3.0, -2.0, 0.3, 0.3}), 0.3);
    check_fit(shape_of<DoubleArcShape>({3.0, -2.0, 0.3, 0.6, 0.35}), 0.3);
}

TEST(OrthogonalFit, AnEllipseIsFoundFromTheCircleAndFromAnyMotion) {
    core::Rng rng(3);
    for (const double ratio : {3.0, 2.0, 1.3, 0.7}) {
        const double b = 0.3, a = ratio * b, turned = rng.uniform(-3.0, 3.0);
        const auto truth =
            shape_of<EllipseShape>({rng.uniform(-90, 90), rng.uniform(-90, 90), turned, b * b / a, b * b / (a * a)});
        std::vector<Vec2> normals;
        std::vector<double> residuals(60);
        const auto points = centres_of(truth, turned, 1.3, 60, 1.0, 0.0, rng, normals);
        EllipseShape::Values start = truth.values();
        start[2] += 0.05;
        start[3] = b;
        start[4] = 1.0;
        const auto fit = fit_orthogonal<EllipseShape>({points, normals, residuals, 1.0}, EllipseShape(start));
        EXPECT_TRUE(fit.converged) << ratio;
        EXPECT_NEAR(fit.shape.semi_axis_along(), a, 1e-6) << ratio;
        EXPECT_NEAR(fit.shape.semi_axis_across(), b, 1e-6) << ratio;
    }
}

}  // namespace
}  // namespace cmm::fitting
