// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing_system.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr double start_ridge = 1e-3;  // weight of the third differences in the start curve, in points
constexpr double start_roughness = 1e-6;
/// So many of the first stand behind the last again, so that none has to look for its neighbours round the end.
constexpr std::size_t lap = 4;
constexpr std::size_t sharing_knots = 3;  // to either side, that share a scale of the roughness
constexpr double student_freedom = 1.0;
/// The most that a control weighs by a jump, in points: what rounding does to stiffer ones shows in the curve (1e-9
/// mm).
constexpr double stiffest = 3e6;

}  // namespace

SmoothingSystem::SmoothingSystem(std::span<const Vec2> points, double sigma_mm,
                                 std::span<const double> supposed_sigma_mm)
    : residual_(points.size()),
      supposed_(supposed_sigma_mm.begin(), supposed_sigma_mm.end()),
      measured_(static_cast<double>(points.size())),
      span_(points.size()),
      basis_(points.size()),
      sigma_(sigma_mm) {
    for (const double sigma : supposed_)
        if (sigma > 0.0) measured_ -= 1.0;
    for (const Vec2& p : points) {
        x_.push_back(p.x());
        y_.push_back(p.y());
    }
}

core::Status SmoothingSystem::start(std::vector<double> breaks, std::span<const double> t) {
    t_.assign(t.begin(), t.end());
    breaks_ = std::move(breaks);
    if (auto status = least_squares_.set_knots(breaks_, true); !status) return status;
    spans_ = least_squares_.spans();
    expected_.assign(spans_, 0.0);
    if (auto status = least_squares_.add({t_, x_, y_}); !status) return status;
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
    const double n = measured_;
    sigma_ = std::max(std::sqrt(residual_squares_ / std::max(n - 0.5 * static_cast<double>(spans_), 0.25 * n)),
                      least_sigma_mm);
    std::vector<double> variance(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        const double h = width(k), square = h * h;
        variance[k] = start_roughness / (square * square * h);
    }
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
    expected_.assign(spans_, 0.0);
    const auto knots = least_squares_.knots();
    controls_.resize(spans_);
    for (std::size_t k = 0; k < spans_; ++k)
        controls_[k] = curve_.blossom(knots[k + 1], knots[k + 2], knots[k + 3]);
    set_curve();
    measure();
    return {};
}

SmoothingSystem::State SmoothingSystem::state() const {
    double largest = 0.0;
    for (std::size_t k = 0; k < spans_; ++k)
        largest = std::max(largest, control_variance(k));
    return {breaks_, t_, controls_, roughness_, sigma_, sigma_ * sigma_ * largest};
}

core::Status SmoothingSystem::restore(const State& state) {
    breaks_ = state.breaks;
    t_ = state.t;
    controls_ = state.controls;
    roughness_ = state.roughness;
    sigma_ = state.sigma_mm;
    if (auto status = least_squares_.set_knots(breaks_, true); !status) return status;
    spans_ = least_squares_.spans();
    expected_.assign(spans_, 0.0);
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

/// Against that of a point, whose variance is `noise`.
double SmoothingSystem::jump_weight(std::size_t knot, double noise) const {
    const double of_middle = jump_row_[knot][2];
    return std::min(noise / roughness_.variance()[knot], stiffest / (of_middle * of_middle));
}

/// The normal displacements of the controls that fit the residuals with the present roughness, or so many times it.
bool SmoothingSystem::solve(double times) {
    const double noise = sigma_ * sigma_ / times;
    weighted_row_.resize(spans_);
    displacement_.resize(spans_ + lap);
    moved_.resize(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        const Five& row = jump_row_[k];
        const double weight = jump_weight(k, noise);
        for (std::size_t a = 0; a < 5; ++a)
            weighted_row_[k][a] = weight * row[a];
        moved_[k] = jump_[k] - expected_[k];
    }
    normal_.reset(spans_, true);
    // Function a of span i - a is that of control i. Written out: the compiler makes shuffles of loops.
    const auto add_row = [&](std::size_t i, const auto& knot) {
        const auto weighted = [&](std::size_t a) -> const Five& { return weighted_row_[knot(a)]; };
        const auto plain = [&](std::size_t a) -> const Five& { return jump_row_[knot(a)]; };
        const auto moved = [&](std::size_t a) { return moved_[knot(a)]; };
        const Five &w0 = weighted(0), &w1 = weighted(1), &w2 = weighted(2), &w3 = weighted(3), &w4 = weighted(4);
        const Five &r0 = plain(0), &r1 = plain(1), &r2 = plain(2), &r3 = plain(3), &r4 = plain(4);
        const Four& g = gram_[i];
        normal_.add_row(i, {g[0] + w0[0] * r0[0] + w1[1] * r1[1] + w2[2] * r2[2] + w3[3] * r3[3] + w4[4] * r4[4],
                            g[1] + w1[1] * r1[0] + w2[2] * r2[1] + w3[3] * r3[2] + w4[4] * r4[3],
                            g[2] + w2[2] * r2[0] + w3[3] * r3[1] + w4[4] * r4[2], g[3] + w3[3] * r3[0] + w4[4] * r4[1],
                            w4[4] * r4[0]});
        displacement_[i] =
            moment_[i] - (w0[0] * moved(0) + w1[1] * moved(1) + w2[2] * moved(2) + w3[3] * moved(3) + w4[4] * moved(4));
    };
    for (std::size_t i = 0; i < lap; ++i)
        add_row(i, [&](std::size_t a) { return before(i, a); });
    for (std::size_t i = lap; i < spans_; ++i)
        add_row(i, [&](std::size_t a) { return i - a; });
    if (!normal_.factor()) return false;
    normal_.solve(std::span(displacement_).first(spans_));
    return true;
}

/// Noise and roughness from the latest solution.
void SmoothingSystem::tune() {
    normal_.invert(inverse_);
    inverse_.resize(spans_ + lap);
    for (std::size_t a = 0; a < lap; ++a) {
        inverse_[spans_ + a] = inverse_[a];
        displacement_[spans_ + a] = displacement_[a];
    }
    told_.resize(spans_);
    double freedom = 3.0;
    const auto& variance = roughness_.variance();
    const double noise = sigma_ * sigma_;
    double squares = residual_squares_;  // |r - B d|^2
    for (std::size_t k = 0; k < spans_; ++k) {
        const Five& row = jump_row_[k];
        double jump = moved_[k], spread = 0.0;
        for (std::size_t a = 0; a < 5; ++a) {
            const auto& inverse = inverse_[k + a];
            jump += row[a] * displacement_[k + a];
            double sum = 0.5 * row[a] * inverse[0];
            for (std::size_t c = a + 1; c < 5; ++c)
                sum += row[c] * inverse[c - a];
            spread += 2.0 * row[a] * sum;
        }
        moved_[k] = jump;
        told_[k] = 1.0 - std::min(1.0, std::max(spread, 0.0) * noise / variance[k]);
        freedom += told_[k];
        double sum = gram_[k][0] * displacement_[k] - 2.0 * moment_[k];
        for (std::size_t m = 1; m < 4; ++m)
            sum += 2.0 * gram_[k][m] * displacement_[before(k, m)];
        squares += displacement_[k] * sum;
    }
    freedom_ = freedom;
    const double n = measured_;
    sigma_ = std::max(std::sqrt(std::max(squares, 0.0) / std::max(n - freedom_, 1.0)), least_sigma_mm);
    roughness_.update(moved_, told_);
}

/// Moves each control along the normal at its Greville abscissa.
void SmoothingSystem::move() {
    const auto knots = least_squares_.knots();  // knot -3 first
    std::vector<Vec2> normals(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        // Control k weighs the first function of span k: knots k - 2, k - 1, k lie under it.
        double t = curve_.wrap((knots[k + 1] + knots[k + 2] + knots[k + 3]) / 3.0);
        const std::size_t middle = before(k, 1), span = curve_.span_of(t, t < breaks_[middle] ? before(k, 2) : middle);
        normals[k] = curve_.jet_in(span, t).right_normal();
    }
    for (std::size_t k = 0; k < spans_; ++k)
        controls_[k] += displacement_[k] * normals[k];
    set_curve();
}

void SmoothingSystem::add_to_common(BandSolver<4>& normal, std::vector<double>& moment, double share_of_jumps) const {
    const double noise = sigma_ * sigma_, weight = 1.0 / noise;
    for (std::size_t i = 0; i < spans_; ++i) {
        const Four& g = gram_[i];
        normal.add_row(i, {weight * g[0], weight * g[1], weight * g[2], weight * g[3], 0.0});
        moment[i] += weight * moment_[i];
    }
    for (std::size_t k = 0; k < spans_; ++k) {
        const Five& row = jump_row_[k];
        const double of_jump = share_of_jumps * weight * jump_weight(k, noise);
        for (std::size_t a = 0; a < 5; ++a)
            for (std::size_t c = 0; c <= a; ++c)
                normal.add(wrapped(k + a), wrapped(k + c), of_jump * row[a] * row[c]);
    }
}

void SmoothingSystem::move_expected(std::span<const double> displacement) {
    for (std::size_t k = 0; k < spans_; ++k) {
        displacement_[k] = displacement[k];
        for (std::size_t a = 0; a < 5; ++a)
            expected_[k] += jump_row_[k][a] * displacement[wrapped(k + a)];
    }
    move();
    measure();
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

bool SmoothingSystem::was_measured(double t) const {
    if (supposed_.empty()) return true;
    const auto behind = static_cast<std::size_t>(std::lower_bound(t_.begin(), t_.end(), t) - t_.begin());
    return supposed_[behind % t_.size()] == 0.0 || supposed_[(behind + t_.size() - 1) % t_.size()] == 0.0;
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

}  // namespace cmm::fitting
