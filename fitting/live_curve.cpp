// SPDX-License-Identifier: Apache-2.0
#include "fitting/live_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

namespace cmm::fitting {

namespace {

constexpr std::size_t window_points = 7;   // 2 um noise at 0.1 mm leaves 0.1/mm of curvature; more would lag at edges
constexpr double window_turn_rad = 0.9;    // a parabola represents this much of a circle to 1 %
constexpr double bad_residual_mm = 0.012;  // a point this far off its neighbours' parabola may be bad

struct Parabola {
    Eigen::Vector3d coefficients = Eigen::Vector3d::Zero();  // y = a + b x + c x^2
    double squares = 0.0;
    bool solved = false;
};

Vec2 rotated(const Vec2& v, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * v.x() - s * v.y(), s * v.x() + c * v.y()};
}

struct Window {
    std::array<Vec2, window_points> local;  // newest first
    std::size_t count = 0;
};

Parabola fit_without(const Window& window, std::size_t skipped) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d rhs = Eigen::Vector3d::Zero();
    std::size_t used = 0;
    for (std::size_t i = 0; i < window.count; ++i) {
        if (i == skipped) continue;
        const double x = window.local[i].x();
        const Eigen::Vector3d row(1.0, x, x * x);
        normal.noalias() += row * row.transpose();
        rhs += window.local[i].y() * row;
        ++used;
    }
    Parabola fit;
    if (used < 3) return fit;
    fit.coefficients = normal.ldlt().solve(rhs);
    for (std::size_t i = 0; i < window.count; ++i) {
        if (i == skipped) continue;
        const double x = window.local[i].x();
        const double r = window.local[i].y() - fit.coefficients.dot(Eigen::Vector3d(1.0, x, x * x));
        fit.squares += r * r;
    }
    fit.solved = fit.coefficients.allFinite();
    return fit;
}

/// The fit without the one point whose removal helps most, when that point is then far off; otherwise with all.
Parabola robust_fit(const Window& window, std::size_t& bad) {
    bad = window_points;
    Parabola best = fit_without(window, window_points);
    if (window.count < 6) return best;
    const Parabola all = best;
    for (std::size_t k = 0; k < window.count; ++k) {
        const Parabola fit = fit_without(window, k);
        if (!fit.solved || fit.squares >= best.squares) continue;
        best = fit;
        bad = k;
    }
    if (bad == window_points) return all;
    const double x = window.local[bad].x();
    const double off = std::abs(window.local[bad].y() - best.coefficients.dot(Eigen::Vector3d(1.0, x, x * x)));
    const double rms = std::sqrt(best.squares / static_cast<double>(window.count - 4));
    // The newest points are extrapolated, so their deleted residual is naturally larger.
    const double leverage = bad == 0 ? 2.0 : 1.0;
    if (off > leverage * std::max(bad_residual_mm, 6.0 * rms)) return best;
    bad = window_points;
    return all;
}

}  // namespace

MaterialSide material_side(const Vec2& outward_normal, const Vec2& travel) {
    return right_normal(travel).dot(outward_normal) >= 0.0 ? MaterialSide::left : MaterialSide::right;
}

LiveCurve::LiveCurve(MaterialSide side, std::size_t reserve) : side_(side == MaterialSide::left ? 1.0 : -1.0) {
    points_.reserve(reserve);
}

void LiveCurve::add(const Vec2& centre) {
    if (!is_finite(centre)) return;
    if (!points_.empty()) {
        const double step = (centre - points_.back()).norm();
        if (!(step > 1e-7)) return;
        length_ += step;
    }
    points_.push_back(centre);
    update_local();
    update_closing();
}

void LiveCurve::update_local() {
    const std::size_t n = points_.size();
    if (n < 3) return;
    // The window reaches back over at most window_turn_rad of the last known curvature, and at least 4 points.
    const double reach = local_.valid && std::abs(local_.curvature) > 1e-9
                             ? window_turn_rad / std::abs(local_.curvature)
                             : std::numeric_limits<double>::infinity();
    std::size_t count = std::min<std::size_t>(n, 4);
    // Two points running that leave the old curve to the same side are no bad points: the part turns, the past is
    // dropped.
    const double leaves = local_.valid ? (points_[n - 1] - local_.position).dot(local_.normal) +
                                             0.5 * local_.curvature * (points_[n - 1] - local_.position).squaredNorm()
                                       : 0.0;
    const bool turns = local_.last_is_bad && leaves * left_by_ > 0.0 && std::abs(leaves) > bad_residual_mm;
    left_by_ = leaves;
    while (!turns && count < std::min(n, window_points) && (points_[n - 1 - count] - points_[n - 1]).norm() <= reach)
        ++count;

    // The frame lies at the middle of the window, where a parabola is closest to a circle through all of it.
    const Vec2 newest = points_[n - 1];
    const double half = 0.5 * (newest - points_[n - count]).norm();
    Vec2 along = (newest - points_[n - count]).normalized();
    if (local_.valid) along = rotated(local_.tangent, -side_ * std::clamp(local_.curvature * half, -0.5, 0.5));
    const Vec2 across = side_ * Vec2(-along.y(), along.x());  // towards the material: convex parts have c > 0
    Window window;
    window.count = count;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec2 d = points_[n - 1 - i] - newest;
        window.local[i] = {d.dot(along) + half, d.dot(across)};
    }
    std::size_t bad = window_points;
    const Parabola fit = robust_fit(window, bad);
    if (!fit.solved) return;
    publish(fit.coefficients, along, across, newest, half);
    local_.last_is_bad = bad == 0;
    if (!start_known_ && n >= 5) {
        start_known_ = true;
        start_tangent_ = (points_[std::min<std::size_t>(n - 1, 4)] - points_[0]).normalized();
    }
}

/// From the parabola at the middle to the circle at the newest point: sin(phi) grows by kappa a millimetre of x.
void LiveCurve::publish(const Eigen::Vector3d& parabola, const Vec2& along, const Vec2& across, const Vec2& newest,
                        double half) {
    const double b = parabola[1], scale = std::sqrt(1.0 + b * b);
    const double curvature = 2.0 * parabola[2] / (scale * scale * scale);
    const double sine0 = b / scale, sine = std::clamp(sine0 + curvature * half, -0.95, 0.95);
    const double cosine0 = 1.0 / scale, cosine = std::sqrt(1.0 - sine * sine);
    const double rise = std::abs(curvature) * half < 1e-6 ? b * half : (cosine0 - cosine) / curvature;
    const Vec2 tangent = cosine * along + sine * across;
    if (local_.valid) turned_ += side_ * turn_angle(local_.tangent, tangent);
    local_.valid = true;
    local_.position = newest + (parabola[0] + rise) * across;
    local_.tangent = tangent;
    local_.normal = side_ * right_normal(tangent);
    local_.curvature = curvature;
}

void LiveCurve::update_closing() {
    const std::size_t n = points_.size();
    // Less than a full turn is enough: at the start the tangent is known to some tenths of a radian only.
    if (!start_known_ || passed_lateral_ >= 0.0 || turned_ < 2.0 * std::numbers::pi - 1.2) return;
    const Vec2 before = points_[n - 2] - points_[0], after = points_[n - 1] - points_[0];
    const Vec2 step = after - before;
    if (step.dot(start_tangent_) <= 0.0) return;
    if (before.dot(start_tangent_) > 0.0 || after.dot(start_tangent_) < 0.0) return;
    passed_lateral_ = std::min(std::abs(cross(start_tangent_, before)), std::abs(cross(start_tangent_, after)));
}

LiveCurve::Prediction LiveCurve::predict(double step_mm) const {
    if (!local_.valid) return {};
    const double angle = side_ * local_.curvature * step_mm;  // positive: turns left
    // sin(x)/x and (1 - cos(x))/x of the arc; the series keeps straight lines exact.
    const bool straight = std::abs(angle) < 1e-6;
    const double forward = straight ? 1.0 : std::sin(angle) / angle;
    const double leftward = straight ? 0.5 * angle : (1.0 - std::cos(angle)) / angle;
    const Vec2 left(-local_.tangent.y(), local_.tangent.x());
    return {true, local_.position + step_mm * (forward * local_.tangent + leftward * left),
            rotated(local_.normal, angle)};
}

double LiveCurve::suggest_step(double min_mm, double max_mm, double chord_error_mm) const {
    // Nothing known, or the newest point disagrees: it is bad or the part turns, the next point must be near to tell.
    if (!local_.valid || local_.last_is_bad) return min_mm;
    const double kappa = std::abs(local_.curvature);
    if (kappa * max_mm * max_mm <= 8.0 * chord_error_mm) return max_mm;
    return std::clamp(std::sqrt(8.0 * chord_error_mm / kappa), min_mm, max_mm);
}

bool LiveCurve::closed(double lateral_tolerance_mm) const {
    return passed_lateral_ >= 0.0 && passed_lateral_ <= lateral_tolerance_mm;
}

}  // namespace cmm::fitting
