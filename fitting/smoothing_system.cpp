// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing_system.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double start_ridge = 1e-3;  // weight of the third differences in the start curve, in points
constexpr double start_roughness = 1e-6;
constexpr std::size_t sharing_knots = 3;  // to either side, that share a scale of the roughness
constexpr double student_freedom = 1.0;
constexpr double least_speed = 0.05;  // of the parameter, which is nearly a length; below it the curve has a cusp
constexpr double longest_correction = 0.01;  // of a foot, of the period

}  // namespace

SmoothingSystem::SmoothingSystem(std::vector<Vec2> points, double sigma_mm)
    : points_(std::move(points)), sigma_(sigma_mm) {
    residual_.resize(points_.size());
    span_.resize(points_.size());
    basis_.resize(points_.size());
}

core::Status SmoothingSystem::start(std::vector<double> breaks, std::span<const double> t) {
    t_.assign(t.begin(), t.end());
    breaks_ = std::move(breaks);
    if (auto status = least_squares_.set_knots(breaks_, true); !status) return status;
    spans_ = least_squares_.spans();
    std::vector<double> x(points_.size()), y(points_.size());
    for (std::size_t i = 0; i < points_.size(); ++i) {
        x[i] = points_[i].x();
        y[i] = points_[i].y();
    }
    if (auto status = least_squares_.add({t_, x, y}); !status) return status;
    for (std::size_t k = 0; k < spans_; ++k) {
        const auto& third = least_squares_.basis(k).power[3];
        BandSolver<3>::Block block{};
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                block[a][c] = start_ridge * 36.0 * third[a] * third[c];
        least_squares_.normal().add_block(k, block);
    }
    if (auto status = least_squares_.solve(); !status) return status;
    controls_ = least_squares_.controls();
    curve_ = least_squares_.curve();
    measure();
    const double n = static_cast<double>(points_.size());
    sigma_ = std::max(std::sqrt(residual_squares_ / std::max(n - 0.5 * static_cast<double>(spans_), 0.25 * n)),
                      least_sigma_mm);
    std::vector<double> variance(spans_);
    for (std::size_t k = 0; k < spans_; ++k)
        variance[k] = start_roughness / std::pow(width(k), 5);
    roughness_.reset(variance, sharing_knots, student_freedom);
    return {};
}

core::Status SmoothingSystem::change_breaks(std::vector<double> breaks, const std::vector<Roughness::Run>& calm) {
    std::vector<std::size_t> from(breaks.size() - 1);
    std::size_t old = 0;
    for (std::size_t k = 0; k < from.size(); ++k) {
        const double t = breaks[k + 1];
        while (old + 1 < spans_ && std::abs(breaks_[old + 2] - t) <= std::abs(breaks_[old + 1] - t))
            ++old;
        from[k] = old;
    }
    roughness_.carry_over(from, calm);
    breaks_ = std::move(breaks);
    if (auto status = least_squares_.set_knots(breaks_, true); !status) return status;
    spans_ = least_squares_.spans();
    const auto knots = least_squares_.knots();
    controls_.resize(spans_);
    for (std::size_t k = 0; k < spans_; ++k)
        controls_[k] = curve_.blossom(knots[k + 1], knots[k + 2], knots[k + 3]);
    set_curve();
    measure();
    return {};
}

core::Status SmoothingSystem::restore(const State& state) {
    breaks_ = state.breaks;
    t_ = state.t;
    controls_ = state.controls;
    roughness_ = state.roughness;
    sigma_ = state.sigma_mm;
    if (auto status = least_squares_.set_knots(breaks_, true); !status) return status;
    spans_ = least_squares_.spans();
    set_curve();
    return {};
}

core::Status SmoothingSystem::refine(int count) {
    for (int tuning = 0; tuning < count; ++tuning) {
        if (!solve()) return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: singular system");
        tune();
    }
    move();
    return {};
}

void SmoothingSystem::measure() {
    measure_points();
    measure_jumps();
    sum_points();
}

void SmoothingSystem::measure_points() {
    const auto& pieces = curve_.pieces();
    const double first = breaks_.front(), last = breaks_.back(), period = last - first;
    std::size_t k = 0;
    const auto span_of = [&](double t) {
        while (k + 1 < spans_ && t >= breaks_[k + 1])
            ++k;
        while (k > 0 && t < breaks_[k])
            --k;
        return k;
    };
    const auto at = [&](std::size_t span, double u, Vec2& d1) -> Vec2 {
        const PiecewiseCubic::Piece& c = pieces[span];
        d1 = c[1] + u * (2.0 * c[2] + 3.0 * u * c[3]);
        return c[0] + u * (c[1] + u * (c[2] + u * c[3]));
    };
    for (std::size_t i = 0; i < t_.size(); ++i) {
        Vec2 d1;
        std::size_t span = span_of(t_[i]);
        const Vec2 off = points_[i] - at(span, t_[i] - breaks_[span], d1);
        double t = t_[i] + std::clamp(off.dot(d1) / std::max(d1.squaredNorm(), least_speed * least_speed),
                                      -longest_correction * period, longest_correction * period);
        if (t < first) t += period;
        if (t >= last) t -= period;
        t_[i] = t;
        span = span_of(t);
        span_[i] = static_cast<std::uint32_t>(span);
        const double u = t - breaks_[span];
        const Vec2 apart = points_[i] - at(span, u, d1);
        residual_[i] = cross(apart, d1) / std::max(d1.norm(), 1e-12);
        basis_[i] = least_squares_.basis(span).at(u / width(span));
    }
}

void SmoothingSystem::measure_jumps() {
    slope_.resize(spans_);
    slope_row_.resize(spans_);
    jump_.resize(spans_);
    jump_row_.resize(spans_);
    length_.resize(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        const double h = width(k), u = 0.5 * h;
        const PiecewiseCubic::Piece& c = curve_.pieces()[k];
        const Vec2 d1 = c[1] + u * (2.0 * c[2] + 3.0 * u * c[3]), d2 = 2.0 * c[2] + 6.0 * u * c[3], d3 = 6.0 * c[3];
        const double speed = std::max(d1.norm(), least_speed), cube = speed * speed * speed;
        const double curvature = cross(d1, d2) / cube;
        slope_[k] = (cross(d1, d3) / cube - 3.0 * cross(d1, d2) * d1.dot(d2) / (cube * speed * speed)) / speed;
        length_[k] = h * speed;
        // A displacement d to the right changes the curvature by -(d'' + curvature^2 d).
        const auto& p = least_squares_.basis(k).power;
        for (std::size_t a = 0; a < 4; ++a) {
            const double first = (p[1][a] + p[2][a] + 0.75 * p[3][a]) / h, third = 6.0 * p[3][a] / (h * h * h);
            slope_row_[k][a] = -(third / cube + curvature * curvature * first / speed);
        }
    }
    for (std::size_t k = 0; k < spans_; ++k) {
        const std::size_t next = wrapped(k + 1);
        const double scale = 1.0 / std::sqrt(0.5 * (length_[k] + length_[next]));
        jump_[k] = scale * (slope_[next] - slope_[k]);
        for (std::size_t a = 0; a < 5; ++a)
            jump_row_[k][a] = scale * ((a > 0 ? slope_row_[next][a - 1] : 0.0) - (a < 4 ? slope_row_[k][a] : 0.0));
    }
}

/// Gram matrix and moments of the points, span by span.
void SmoothingSystem::sum_points() {
    gram_.assign(spans_, {});
    moment_.assign(spans_, Four{});
    residual_squares_ = 0.0;
    for (std::size_t i = 0; i < basis_.size();) {
        const std::uint32_t span = span_[i];
        auto gram = gram_[span];
        Four moment = moment_[span];
        for (; i < basis_.size() && span_[i] == span; ++i) {
            const Four& b = basis_[i];
            residual_squares_ += residual_[i] * residual_[i];
            for (std::size_t a = 0; a < 4; ++a) {
                moment[a] += b[a] * residual_[i];
                for (std::size_t c = 0; c <= a; ++c)
                    gram[a][c] += b[a] * b[c];
            }
        }
        gram_[span] = gram;
        moment_[span] = moment;
    }
    for (auto& gram : gram_)
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t c = a + 1; c < 4; ++c)
                gram[a][c] = gram[c][a];
}

/// The normal displacements of the controls that fit the residuals with the present roughness, or so many times it.
bool SmoothingSystem::solve(double times) {
    normal_.reset(spans_, true);
    displacement_.assign(spans_, 0.0);
    const auto& variance = roughness_.variance();
    for (std::size_t k = 0; k < spans_; ++k) {
        const double weight = sigma_ * sigma_ / (times * variance[k]);
        const Five& row = jump_row_[k];
        BandSolver<4>::Block block;
        for (std::size_t a = 0; a < 5; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                block[a][c] = weight * row[a] * row[c] + (a < 4 ? gram_[k][a][c] : 0.0);
        normal_.add_block(k, block);
        for (std::size_t a = 0; a < 5; ++a)
            displacement_[wrapped(k + a)] += (a < 4 ? moment_[k][a] : 0.0) - weight * row[a] * jump_[k];
    }
    if (!normal_.factor()) return false;
    normal_.solve(std::span(displacement_));
    return true;
}

/// Noise and roughness from the latest solution.
void SmoothingSystem::tune() {
    normal_.invert(inverse_);
    moved_.resize(spans_);
    uncertain_.resize(spans_);
    freedom_ = 3.0;
    const auto& variance = roughness_.variance();
    for (std::size_t k = 0; k < spans_; ++k) {
        const Five& row = jump_row_[k];
        double jump = jump_[k], spread = 0.0;
        for (std::size_t a = 0; a < 5; ++a) {
            const std::size_t control = wrapped(k + a);
            const auto& inverse = inverse_[control];
            jump += row[a] * displacement_[control];
            double sum = 0.5 * row[a] * inverse[0];
            for (std::size_t c = a + 1; c < 5; ++c)
                sum += row[c] * inverse[c - a];
            spread += 2.0 * row[a] * sum;
        }
        moved_[k] = jump;
        uncertain_[k] = std::max(spread, 0.0) * sigma_ * sigma_;
        freedom_ += 1.0 - std::min(1.0, uncertain_[k] / variance[k]);
    }
    double squares = residual_squares_;  // |r - B d|^2 from the sums over the spans
    for (std::size_t k = 0; k < spans_; ++k)
        for (std::size_t a = 0; a < 4; ++a) {
            const double d = displacement_[wrapped(k + a)];
            double sum = -2.0 * moment_[k][a];
            for (std::size_t c = 0; c < 4; ++c)
                sum += gram_[k][a][c] * displacement_[wrapped(k + c)];
            squares += d * sum;
        }
    const double n = static_cast<double>(basis_.size());
    sigma_ = std::max(std::sqrt(std::max(squares, 0.0) / std::max(n - freedom_, 1.0)), least_sigma_mm);
    roughness_.update(moved_, uncertain_);
}

/// Moves each control along the normal at its Greville abscissa.
void SmoothingSystem::move() {
    const auto knots = least_squares_.knots();  // knot -3 first
    std::vector<Vec2> normals(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        // Control k weighs the first function of span k: knots k - 2, k - 1, k lie under it.
        const double t = (knots[k + 1] + knots[k + 2] + knots[k + 3]) / 3.0;
        const Jet jet = curve_.jet(t);
        normals[k] = jet.right_normal();
    }
    for (std::size_t k = 0; k < spans_; ++k)
        controls_[k] += displacement_[k] * normals[k];
    set_curve();
}

void SmoothingSystem::set_curve() {
    std::vector<PiecewiseCubic::Piece> pieces(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        double scale = 1.0;
        for (std::size_t power = 0; power < 4; ++power, scale /= width(k)) {
            Vec2 sum = Vec2::Zero();
            for (std::size_t a = 0; a < 4; ++a)
                sum += least_squares_.basis(k).power[power][a] * controls_[wrapped(k + a)];
            pieces[k][power] = scale * sum;
        }
    }
    curve_ = PiecewiseCubic(breaks_, std::move(pieces), true);
}

double SmoothingSystem::variance(std::size_t span, const Four& values) const {
    double sum = 0.0;
    for (std::size_t a = 0; a < 4; ++a) {
        const auto& row = inverse_[wrapped(span + a)];
        sum += values[a] * values[a] * row[0];
        for (std::size_t c = a + 1; c < 4; ++c)
            sum += 2.0 * values[a] * values[c] * row[c - a];
    }
    return sum;
}

double SmoothingSystem::leverage(std::size_t point) const {
    return std::clamp(variance(span_[point], basis_[point]), 0.0, 1.0);
}

double SmoothingSystem::step_variance(double from_t, double to_t) const {
    std::vector<double> row(spans_, 0.0);
    for (auto [t, sign] : {std::pair{from_t, -1.0}, std::pair{to_t, 1.0}}) {
        const std::size_t span = curve_.span_of(t);
        const Jet jet = curve_.jet(t);
        const double h = width(span), w = (t - breaks_[span]) / h, speed = jet.d1.norm(), curvature = jet.curvature();
        const auto& p = least_squares_.basis(span).power;
        for (std::size_t a = 0; a < 4; ++a) {
            const double value = p[0][a] + w * (p[1][a] + w * (p[2][a] + w * p[3][a]));
            const double second = (2.0 * p[2][a] + 6.0 * w * p[3][a]) / (h * h * speed * speed);
            row[wrapped(span + a)] -= sign * (second + curvature * curvature * value);
        }
    }
    std::vector<double> answer = row;
    normal_.solve(std::span(answer));
    double sum = 0.0;
    for (std::size_t k = 0; k < spans_; ++k)
        sum += row[k] * answer[k];
    return sigma_ * sigma_ * sum;
}

CurveNoise SmoothingSystem::noise(double times) && {
    if (solve(times)) normal_.invert(inverse_);
    std::vector<Four> covariance(spans_);
    for (std::size_t k = 0; k < spans_; ++k)
        for (std::size_t m = 0; m < 4; ++m)
            covariance[k][m] = sigma_ * sigma_ * inverse_[k][m];
    std::vector<CubicBasis> bases;
    for (std::size_t k = 0; k < spans_; ++k)
        bases.push_back(least_squares_.basis(k));
    return CurveNoise(std::move(breaks_), std::move(bases), std::move(covariance),
                      std::make_shared<const BandSolver<4>>(std::move(normal_)), sigma_);
}

}  // namespace cmm::fitting
