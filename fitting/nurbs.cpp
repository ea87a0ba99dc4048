// SPDX-License-Identifier: Apache-2.0
#include "fitting/nurbs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <Eigen/Core>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

struct Basis {
    std::size_t first = 0;  // index of the first of the four control points
    std::array<double, 4> value{}, slope{};
};

/// The cubic basis functions at u and their derivatives by the recursion of eq 7 (0/0 = 0, last span closed).
Basis basis_at(const std::vector<double>& knots, double u) {
    const std::size_t controls = knots.size() - 4;
    const auto above = std::upper_bound(knots.begin() + 4, knots.begin() + static_cast<std::ptrdiff_t>(controls), u);
    const auto span = static_cast<std::size_t>(above - knots.begin()) - 1;
    std::array<double, 4> lower{1.0, 0.0, 0.0, 0.0}, value = lower;
    for (std::size_t degree = 1; degree <= 3; ++degree) {
        lower = value;
        value.fill(0.0);
        for (std::size_t j = 0; j < degree; ++j) {
            const double left = knots[span + 1 + j - degree], right = knots[span + 1 + j], width = right - left;
            if (!(width > 0.0)) continue;
            value[j] += (right - u) / width * lower[j];
            value[j + 1] += (u - left) / width * lower[j];
        }
    }
    Basis basis{span - 3, value, {}};
    for (std::size_t j = 0; j < 3; ++j) {  // lower holds the quadratic functions
        const double width = knots[span + 1 + j] - knots[span + j - 2];
        if (!(width > 0.0)) continue;
        basis.slope[j] -= 3.0 * lower[j] / width;
        basis.slope[j + 1] += 3.0 * lower[j] / width;
    }
    return basis;
}

/// Eq 8 with the sum running over the n - 1 chords that exist.
std::vector<double> chord_knots(std::span<const Vec2> points) {
    const std::vector<double> chords = chord_parameters(points, false);
    std::vector<double> knots(3, 0.0);
    for (const double c : chords)
        knots.push_back(c / chords.back());
    knots.back() = 1.0;
    knots.insert(knots.end(), 3, 1.0);
    return knots;
}

/// Solves the interpolation equations for homogeneous control points (x w, y w, w): two end rows and n data rows, each
/// with three neighbours (N_{i+3} vanishes at its knot), by Gaussian elimination without pivoting (diagonally
/// dominant).
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

void solve_tridiagonal(std::vector<std::array<double, 3>>& bands, Rows& rhs) {
    const auto n = static_cast<Eigen::Index>(bands.size());
    for (Eigen::Index i = 1; i < n; ++i) {
        auto& row = bands[static_cast<std::size_t>(i)];
        const auto& above = bands[static_cast<std::size_t>(i - 1)];
        const double factor = row[0] / above[1];
        row[1] -= factor * above[2];
        rhs.row(i) -= factor * rhs.row(i - 1);
    }
    for (Eigen::Index i = n; i-- > 0;) {
        const auto& row = bands[static_cast<std::size_t>(i)];
        if (i + 1 < n) rhs.row(i) -= row[2] * rhs.row(i + 1);
        rhs.row(i) /= row[1];
    }
}

core::Status check(std::span<const Vec2> points, std::span<const double> weights) {
    if (points.size() < 2) return core::fail(ErrorCode::fit_not_evaluable, "NURBS: needs 2 points");
    if (!weights.empty() && weights.size() != points.size())
        return core::fail(ErrorCode::fit_not_evaluable, "NURBS: as many weights as points are needed");
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (!is_finite(points[i]) || (i > 0 && !((points[i] - points[i - 1]).norm() > 0.0)))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "NURBS: point " + std::to_string(i) + " repeats or is not finite");
        if (!weights.empty() && !(weights[i] > 0.0))
            return core::fail(ErrorCode::fit_not_evaluable, "NURBS: weight " + std::to_string(i) + " is not positive");
    }
    return {};
}

}  // namespace

NurbsCurve::NurbsCurve(std::vector<double> knots, std::vector<Vec2> controls, std::vector<double> weights)
    : knots_(std::move(knots)), controls_(std::move(controls)), weights_(std::move(weights)) {}

NurbsCurve::Homogeneous NurbsCurve::evaluate(double u) const {
    const Basis basis = basis_at(knots_, std::clamp(u, 0.0, 1.0));
    Homogeneous h;
    for (std::size_t j = 0; j < 4; ++j) {
        const double w = weights_[basis.first + j];
        h.weighted += basis.value[j] * w * controls_[basis.first + j];
        h.weighted_d += basis.slope[j] * w * controls_[basis.first + j];
        h.weight += basis.value[j] * w;
        h.weight_d += basis.slope[j] * w;
    }
    return h;
}

Vec2 NurbsCurve::position(double u) const {
    const Homogeneous h = evaluate(u);
    return h.weighted / h.weight;
}

Vec2 NurbsCurve::derivative(double u) const {
    const Homogeneous h = evaluate(u);
    return (h.weighted_d - h.weight_d * (h.weighted / h.weight)) / h.weight;
}

core::Result<NurbsCurve> interpolate_nurbs(std::span<const Vec2> points, std::span<const double> weights,
                                           const EndConditions& ends) {
    if (auto status = check(points, weights); !status) return tl::unexpected(status.error());
    const std::size_t n = points.size(), controls = n + 2;
    const double total = chord_parameters(points, false).back();
    std::vector<double> knots = chord_knots(points);
    std::vector<std::array<double, 3>> bands(controls, {0.0, 0.0, 0.0});
    Rows rhs = Rows::Zero(static_cast<Eigen::Index>(controls), 3);
    const auto weight = [&](std::size_t i) { return weights.empty() ? 1.0 : weights[i]; };

    // Data rows (12) and (9): at u_{i+3} the functions i, i+1, i+2 are left. The clamped ends are rows 0 and n + 1.
    for (std::size_t i = 0; i < n; ++i) {
        const std::size_t row = i == 0 ? 0 : i + 1 == n ? controls - 1 : i + 1;
        const double w = weight(i);
        rhs.row(static_cast<Eigen::Index>(row)) << w * points[i].x(), w * points[i].y(), w;
        if (row == 0 || row == controls - 1) {
            bands[row] = {0.0, 1.0, 0.0};
            continue;
        }
        const Basis basis = basis_at(knots, knots[i + 3]);
        bands[row] = {basis.value[0], basis.value[1], basis.value[2]};
    }
    // End rows. Derivative of the homogeneous curve: 3 (P_1 - P_0) / (u_4 - u_3) (eq 10, 13); the weight's slope is
    // zero, so the curve's own derivative times the end weight stands on the right. Natural: second derivative zero.
    const auto end_row = [&](bool start) {
        const std::size_t row = start ? 1 : n;
        const auto& tangent = start ? ends.start_tangent : ends.end_tangent;
        const double h = start ? knots[4] - knots[3] : knots[n + 2] - knots[n + 1];
        const double w = weight(start ? 0 : n - 1);
        const auto at = static_cast<Eigen::Index>(row);
        const double sign = start ? 1.0 : -1.0;
        if (tangent && tangent->norm() > 0.0) {
            bands[row] = {0.0, 1.0, 0.0};
            bands[row][start ? 0 : 2] = -1.0;
            const Vec2 d = sign * w * total * h / 3.0 * tangent->normalized();
            rhs.row(at) << d.x(), d.y(), 0.0;
            return;
        }
        // Natural: (P_2 - P_1)/(h + h') = (P_1 - P_0)/h with h' the next knot interval (0 when there is none).
        const double next = n < 3 ? 0.0 : (start ? knots[5] - knots[4] : knots[n + 1] - knots[n]);
        const double outer = 1.0 / h, inner = 1.0 / (h + next);
        bands[row] = {start ? -outer : -inner, outer + inner, start ? -inner : -outer};
    };
    end_row(true);
    end_row(false);
    solve_tridiagonal(bands, rhs);

    std::vector<Vec2> points_out(controls);
    std::vector<double> weights_out(controls);
    for (std::size_t j = 0; j < controls; ++j) {
        const auto at = static_cast<Eigen::Index>(j);
        weights_out[j] = rhs(at, 2);
        if (!(weights_out[j] > 0.0))
            return core::fail(ErrorCode::fit_not_evaluable,
                              "NURBS: these data weights need a control weight that is not positive");
        points_out[j] = Vec2(rhs(at, 0), rhs(at, 1)) / rhs(at, 2);
    }
    return NurbsCurve(std::move(knots), std::move(points_out), std::move(weights_out));
}

}  // namespace cmm::fitting
