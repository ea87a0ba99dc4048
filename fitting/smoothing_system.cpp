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
constexpr double least_speed = 0.05;  // of the parameter, which is nearly a length; below it the curve has a cusp
constexpr double longest_correction = 0.01;  // of a foot, of the period
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

void SmoothingSystem::measure() {
    measure_points();
    measure_jumps();
    sum_points();
}

/// Calls work(span, first, end) for the points, run by run, that lie in the same span.
template <class Work>
void SmoothingSystem::for_each_run(const Work& work) const {
    std::size_t span = 0;
    for (std::size_t first = 0; first < t_.size();) {
        while (span + 1 < spans_ && t_[first] >= breaks_[span + 1])
            ++span;
        while (span > 0 && t_[first] < breaks_[span])
            --span;
        const double low = breaks_[span], high = breaks_[span + 1];
        std::size_t end = first + 1;
        while (end < t_.size() && t_[end] >= low && t_[end] < high)
            ++end;
        work(span, first, end);
        first = end;
    }
}

/// Several points of one span at once, in vector lanes.
template <int Count>
struct SmoothingSystem::Lanes {
    using Array = Eigen::Array<double, Count, 1>;
    Array u, x, y, dx, dy;  // from the span's beginning; the curve and its derivative there

    Lanes(const PiecewiseCubic::Piece& c, const Array& from_break) : u(from_break) {
        x = c[0].x() + u * (c[1].x() + u * (c[2].x() + u * c[3].x()));
        y = c[0].y() + u * (c[1].y() + u * (c[2].y() + u * c[3].y()));
        dx = c[1].x() + u * (2.0 * c[2].x() + u * (3.0 * c[3].x()));
        dy = c[1].y() + u * (2.0 * c[2].y() + u * (3.0 * c[3].y()));
    }
};

template <int Count>
void SmoothingSystem::move_feet(std::size_t span, std::size_t first) {
    using Array = typename Lanes<Count>::Array;
    Eigen::Map<Array> t(&t_[first]);
    const Lanes<Count> at(curve_.pieces()[span], t - breaks_[span]);
    const Array off_x = Eigen::Map<const Array>(&x_[first]) - at.x, off_y = Eigen::Map<const Array>(&y_[first]) - at.y;
    const double most = longest_correction * (breaks_.back() - breaks_.front());
    const Array squared = (at.dx * at.dx + at.dy * at.dy).max(least_speed * least_speed);
    t += ((off_x * at.dx + off_y * at.dy) / squared).max(-most).min(most);
}

template <int Count>
void SmoothingSystem::measure_residuals(std::size_t span, std::size_t first) {
    using Array = typename Lanes<Count>::Array;
    const Lanes<Count> at(curve_.pieces()[span], Eigen::Map<const Array>(&t_[first]) - breaks_[span]);
    const Array off_x = Eigen::Map<const Array>(&x_[first]) - at.x, off_y = Eigen::Map<const Array>(&y_[first]) - at.y;
    Eigen::Map<Array> residual(&residual_[first]);
    residual = (off_x * at.dy - off_y * at.dx) / (at.dx * at.dx + at.dy * at.dy).sqrt().max(1e-12);
    const Array w = at.u / width(span);
    for (int i = 0; i < Count; ++i) {
        basis_[first + static_cast<std::size_t>(i)] = least_squares_.basis(span).at(w[i]);
        span_[first + static_cast<std::size_t>(i)] = static_cast<std::uint32_t>(span);
    }
}

void SmoothingSystem::measure_points() {
    for_each_run([&](std::size_t span, std::size_t i, std::size_t end) {
        for (; i + 3 < end; i += 4)
            move_feet<4>(span, i);
        for (; i + 1 < end; i += 2)
            move_feet<2>(span, i);
        if (i < end) move_feet<1>(span, i);
    });
    const double first = breaks_.front(), last = breaks_.back(), period = last - first;
    for (double& t : t_) {
        if (t < first) t += period;
        if (t >= last) t -= period;
    }
    for_each_run([&](std::size_t span, std::size_t i, std::size_t end) {
        for (; i + 3 < end; i += 4)
            measure_residuals<4>(span, i);
        for (; i + 1 < end; i += 2)
            measure_residuals<2>(span, i);
        if (i < end) measure_residuals<1>(span, i);
    });
}

void SmoothingSystem::measure_jumps() {
    slope_.resize(spans_);
    slope_row_.resize(spans_);
    jump_.resize(spans_);
    jump_row_.resize(spans_);
    length_.resize(spans_);
    for (std::size_t k = 0; k < spans_; ++k) {
        const double h = width(k), u = 0.5 * h, per_h = 1.0 / h;
        const PiecewiseCubic::Piece& c = curve_.pieces()[k];
        const Vec2 d1 = c[1] + u * (2.0 * c[2] + 3.0 * u * c[3]), d2 = 2.0 * c[2] + 6.0 * u * c[3], d3 = 6.0 * c[3];
        const double speed = std::max(d1.norm(), least_speed), slowness = 1.0 / speed;
        const double square = slowness * slowness, cube = square * slowness, turn = cross(d1, d2);
        const double curvature = cube * turn;
        slope_[k] = square * square * (cross(d1, d3) - 3.0 * square * turn * d1.dot(d2));
        length_[k] = h * speed;
        // A displacement d to the right changes the curvature by -(d'' + curvature^2 d).
        const double of_third = -6.0 * cube * per_h * per_h * per_h;
        const double of_first = -curvature * curvature * slowness * per_h;
        const auto& p = least_squares_.basis(k).power;
        for (std::size_t a = 0; a < 4; ++a)
            slope_row_[k][a] = of_third * p[3][a] + of_first * (p[1][a] + p[2][a] + 0.75 * p[3][a]);
    }
    for (std::size_t k = 0; k < spans_; ++k) {
        const std::size_t next = wrapped(k + 1);
        const double scale = 1.0 / std::sqrt(mean_length_mm(k));
        jump_[k] = scale * (slope_[next] - slope_[k]);
        for (std::size_t a = 0; a < 5; ++a)
            jump_row_[k][a] = scale * ((a > 0 ? slope_row_[next][a - 1] : 0.0) - (a < 4 ? slope_row_[k][a] : 0.0));
    }
}

/// Of a point, against one that was measured.
double SmoothingSystem::weight_of(std::size_t point) const {
    if (supposed_.empty() || !(supposed_[point] > 0.0)) return 1.0;
    const double share = std::min(sigma_ / supposed_[point], 1.0);
    return share * share;
}

/// Gram matrix and moments of the points.
void SmoothingSystem::sum_points() {
    using Array = Eigen::Array4d;
    gram_.assign(spans_, Four{});
    moment_.assign(spans_, 0.0);
    double squares = 0.0;
    for (std::size_t i = 0; i < basis_.size();) {
        const std::uint32_t span = span_[i];
        // In registers. Row a of the Gram matrix is needed up to the diagonal.
        Array g0 = Array::Zero(), g1 = g0, g2 = g0, g3 = g0, moment = g0;
        for (; i < basis_.size() && span_[i] == span; ++i) {
            const Array b(basis_[i].data()), weighted = weight_of(i) * b;
            squares += weight_of(i) * residual_[i] * residual_[i];
            moment += residual_[i] * weighted;
            g0 += b[0] * weighted;
            g1 += b[1] * weighted;
            g2 += b[2] * weighted;
            g3 += b[3] * weighted;
        }
        const std::array<const Array*, 4> gram{&g0, &g1, &g2, &g3};
        for (std::size_t a = 0; a < 4; ++a) {
            const std::size_t control = wrapped(span + a);
            moment_[control] += moment[static_cast<int>(a)];
            for (std::size_t c = 0; c <= a; ++c)
                gram_[control][a - c] += (*gram[a])[static_cast<int>(c)];
        }
    }
    residual_squares_ = squares;
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
