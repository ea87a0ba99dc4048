// SPDX-License-Identifier: Apache-2.0
#include "fitting/offset.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fitting/trimming.hpp"

namespace cmm::fitting {
namespace {

constexpr double turn_share = 0.25;
constexpr double corner_step_rad = 0.02;

class Sampler {
  public:
    Sampler(const ParallelCurve& curve, std::size_t count) : curve_(curve), source_(curve.source()) {
        const auto& breaks = source_.breaks();
        const std::size_t n = source_.spans();
        std::vector<double> turn(n, 0.0);
        double total = 0.0;
        for (const Stretch& s : curve.stretches()) {
            if (s.about_corner) continue;
            turn[s.span] += s.turn;
            total += s.turn;
        }
        step_.resize(n);
        for (std::size_t k = 0; k < n; ++k) {
            const double width = breaks[k + 1] - breaks[k];
            const double share = (1.0 - turn_share) * width / source_.period() + turn_share * turn[k] / total;
            step_[k] = width / std::max(1.0, std::ceil(share * static_cast<double>(count)));
        }
        points_.reserve(count + n);
    }

    void append(const TrimmedLoop& loop) {
        for (std::size_t i = 0; i < loop.branches.size(); ++i) {
            const Branch& branch = loop.branches[i];
            for (const StretchPart& part : branch)
                append(part, !loop.smooth && &part == &branch.front());
            if (!loop.smooth) add_corner(branch.back(), loop.branches[(i + 1) % loop.branches.size()].front());
        }
    }

    std::vector<OffsetPoint> take() && { return std::move(points_); }

  private:
    void add_corner(const StretchPart& before, const StretchPart& after) {
        add(before.stretch, before.to);
        Vec2& normal = points_.back().normal;
        normal = (normal + curve_.at(curve_.stretches()[after.stretch], after.from).normal).normalized();
    }

    void add(std::size_t stretch, double x) { points_.push_back(curve_.at(curve_.stretches()[stretch], x)); }

    /// From the part's beginning (`open`: after it) to before its end.
    void append(const StretchPart& part, bool open) {
        const Stretch& s = curve_.stretches()[part.stretch];
        if (s.about_corner) {
            const auto parts = static_cast<std::size_t>(std::ceil(std::abs(part.to - part.from) / corner_step_rad));
            for (std::size_t j = open ? 1 : 0; j < parts; ++j)
                add(part.stretch,
                    part.from + (part.to - part.from) * static_cast<double>(j) / static_cast<double>(parts));
            return;
        }
        constexpr double slack = 1e-9;
        const double origin = source_.breaks()[s.span], step = step_[s.span];
        const double low = (part.from - origin) / step, high = std::ceil((part.to - origin) / step - slack);
        const double first = open ? std::floor(low + slack) + 1.0 : std::ceil(low - slack);
        if (high > first) append(s.span, origin + first * step, step, static_cast<std::size_t>(high - first));
    }

    /// Points at first, first + step, ...: four at a time.
    void append(std::size_t span, double first, double step, std::size_t count) {
        using Lanes = Eigen::Array<double, 4, 1>;
        const auto& [a, b, c, d] = source_.pieces()[span];
        const double origin = source_.breaks()[span], distance = curve_.distance();
        const Lanes index(0.0, 1.0, 2.0, 3.0);
        for (std::size_t j = 0; j < count; j += 4) {
            const Lanes t = first + step * (index + static_cast<double>(j)), u = t - origin;
            const Lanes dx = b.x() + u * (2.0 * c.x() + u * (3.0 * d.x()));
            const Lanes dy = b.y() + u * (2.0 * c.y() + u * (3.0 * d.y()));
            const Lanes inverse = (dx * dx + dy * dy).sqrt().inverse();
            const Lanes nx = dy * inverse, ny = -dx * inverse;
            const Lanes x = a.x() + u * (b.x() + u * (c.x() + u * d.x())) + distance * nx;
            const Lanes y = a.y() + u * (b.y() + u * (c.y() + u * d.y())) + distance * ny;
            for (std::size_t k = 0; k < std::min<std::size_t>(4, count - j); ++k)
                points_.push_back({{x[k], y[k]}, {nx[k], ny[k]}, t[k], false});
        }
    }

    const ParallelCurve& curve_;
    const PiecewiseCubic& source_;
    std::vector<double> step_;  // of the parameter, by piece
    std::vector<OffsetPoint> points_;
};

std::vector<OffsetCorner> corners_of(const ParallelCurve& curve, const TrimmedLoop& loop) {
    std::vector<OffsetCorner> corners;
    if (loop.smooth) return corners;
    for (std::size_t i = 0; i < loop.branches.size(); ++i) {
        const StretchPart& last = loop.branches[i].back();
        const StretchPart& next = loop.branches[(i + 1) % loop.branches.size()].front();
        const OffsetPoint end = curve.at(curve.stretches()[last.stretch], last.to);
        corners.push_back({end.position, end.t, curve.at(curve.stretches()[next.stretch], next.from).t});
    }
    return corners;
}

}  // namespace

Offset offset_curve(const PiecewiseCubic& source, double distance_mm, std::size_t count) {
    const ParallelCurve curve(source, distance_mm);
    const TrimmedLoop loop = largest_loop(curve);
    Sampler sampler(curve, count);
    sampler.append(loop);
    return {std::move(sampler).take(), corners_of(curve, loop)};
}

LeanError lean_error(double ball_radius_mm, double lean_rad) {
    constexpr double flattest = 0.1;
    const double cosine = std::max(std::cos(lean_rad), flattest);
    return {ball_radius_mm * (1.0 / cosine - 1.0), ball_radius_mm * (1.0 - cosine),
            ball_radius_mm * std::sin(lean_rad)};
}

}  // namespace cmm::fitting
