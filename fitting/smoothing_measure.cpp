// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "fitting/smoothing_system.hpp"

namespace cmm::fitting {
namespace {

constexpr double longest_correction = 0.01;  // of a foot, of the period
constexpr double least_speed = 0.05;  // of the parameter, which is nearly a length; below it the curve has a cusp

}  // namespace

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

}  // namespace cmm::fitting
