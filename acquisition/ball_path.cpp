// SPDX-License-Identifier: Apache-2.0
#include "acquisition/ball_path.hpp"

#include <algorithm>
#include <cmath>

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using fitting::ClosedCurve;

constexpr double finest_step_mm = 0.02;
constexpr double most_steps = 4000.0;
constexpr double touching_mm = 5e-4;  // nearer than this below the radius counts as touching
constexpr double reported_mm = 5e-3;  // bridged places less deep than this are texture

BallPoint ball_point(const ClosedCurve& contour, double s, double radius) {
    const auto at = contour.evaluate(s);
    return {at.position + radius * at.normal, at.normal, contour.wrap(s), 0.0};
}

/// By how much the ball, touching at s, enters the material elsewhere.
double overlap_at(const ClosedCurve& contour, double s, double radius) {
    return radius - contour.closest(ball_point(contour, s, radius).centre_mm).distance_mm;
}

/// The contact between a free one and a blocked one at which the ball just touches in two places.
double last_free(const ClosedCurve& contour, double free, double blocked, double radius) {
    for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (free + blocked);
        (overlap_at(contour, middle, radius) > touching_mm ? blocked : free) = middle;
    }
    return free;
}

/// Length of path over which the curvature is averaged: what lies within a pitch cannot be resolved anyway, and facets
/// and texture of a measured nominal have no curvature of their own.
std::vector<double> smoothed_curvature(const std::vector<BallPoint>& points, const std::vector<double>& length,
                                       double window) {
    const std::size_t n = points.size();
    std::vector<double> angle(n + 1, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
        const Vector2d &a = points[i].normal, &b = points[(i + 1) % n].normal;
        angle[i + 1] = angle[i] + std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
    const double lap = length.back(), turn = angle.back();
    // Angle at any arc length: linear between the points, one turn more a lap.
    const auto angle_at = [&](double s) {
        const double laps = std::floor(s / lap);
        s -= laps * lap;
        const auto after = std::upper_bound(length.begin() + 1, length.end() - 1, s);
        const auto i = static_cast<std::size_t>(after - length.begin()) - 1;
        const double width = length[i + 1] - length[i];
        const double part = width > 0.0 ? (s - length[i]) / width : 0.0;
        return laps * turn + angle[i] + part * (angle[i + 1] - angle[i]);
    };
    std::vector<double> curvature(n);
    for (std::size_t i = 0; i < n; ++i) {
        curvature[i] = std::abs(angle_at(length[i] + 0.5 * window) - angle_at(length[i] - 0.5 * window)) / window;
    }
    return curvature;
}

std::vector<double> path_length(const std::vector<BallPoint>& points) {
    std::vector<double> length(points.size() + 1, 0.0);
    for (std::size_t i = 0; i < points.size(); ++i) {
        length[i + 1] = length[i] + (points[(i + 1) % points.size()].centre_mm - points[i].centre_mm).norm();
    }
    return length;
}

bool inside(const fitting::ZoneSpan& span, const ClosedCurve& curve, double s) {
    return curve.ahead(span.from_mm, s) <= span.to_mm - span.from_mm;
}

/// The wanted step at every point of the dense path.
std::vector<double> local_steps(const BallPath& path, const std::vector<double>& length,
                                const fitting::NominalSection& section, const SamplingOptions& options) {
    constexpr double growth = 0.25;  // the step changes by at most this per length: a smooth transition
    const double finest = options.pitch_mm / options.edge_density;
    const std::size_t n = path.points.size();
    const auto curvature = smoothed_curvature(path.points, length, options.pitch_mm);
    std::vector<double> step(n);
    for (std::size_t i = 0; i < n; ++i) {
        const double s = path.points[i].contour_mm;
        const bool edge =
            inside(section.le_span(), section.curve(), s) || inside(section.te_span(), section.curve(), s);
        const double by_curvature =
            curvature[i] > 0.0 ? std::sqrt(8.0 * options.chord_error_mm / curvature[i]) : options.pitch_mm;
        step[i] = edge ? finest : std::clamp(by_curvature, finest, options.pitch_mm);
    }
    for (std::size_t i = 1; i < 2 * n; ++i) {
        const std::size_t from = (i - 1) % n;
        step[i % n] = std::min(step[i % n], step[from] + growth * (length[from + 1] - length[from]));
    }
    for (std::size_t i = 2 * n - 1; i-- > 0;) {
        const std::size_t at = i % n;
        step[at] = std::min(step[at], step[(at + 1) % n] + growth * (length[at + 1] - length[at]));
    }
    return step;
}

/// Middle of the suction side on the contour.
double middle_of_suction(const fitting::NominalSection& section) {
    const auto& curve = section.curve();
    const auto &le = section.le_span(), &te = section.te_span();
    const double after_le = le.to_mm + 0.5 * curve.ahead(le.to_mm, te.from_mm);
    const double after_te = te.to_mm + 0.5 * curve.ahead(te.to_mm, le.from_mm);
    return curve.wrap(section.zone_at(curve.wrap(after_le)) == fitting::Zone::suction ? after_le : after_te);
}

/// Between two points of the dense path: exactly, by the contact on the contour; where a hollow lies between their
/// contacts, the nearer of the two.
BallPoint between(const BallPoint& a, const BallPoint& b, double part, const ClosedCurve& contour, double radius,
                  double dense_step) {
    const double apart = contour.ahead(a.contour_mm, b.contour_mm);
    if (apart < 1.01 * dense_step) return ball_point(contour, a.contour_mm + part * apart, radius);
    return part < 0.5 ? a : b;
}

/// Where the contour is concave and sharper than the ball for a very short stretch, the parallel curve runs back and
/// forth without entering the material by anything that shows: only what lies ahead of the last point is kept.
std::vector<BallPoint> forward_only(const std::vector<BallPoint>& points) {
    std::vector<BallPoint> kept;
    for (const auto& point : points) {
        if (!kept.empty()) {
            const Vector2d& n = kept.back().normal;
            if ((point.centre_mm - kept.back().centre_mm).dot(Vector2d(-n.y(), n.x())) <= 0.0) continue;
        }
        kept.push_back(point);
    }
    return kept;
}

}  // namespace

BallPath ball_path(const ClosedCurve& contour, double ball_radius_mm) {
    const double step = std::max(finest_step_mm, contour.length() / most_steps);
    const auto n = static_cast<std::size_t>(std::ceil(contour.length() / step));
    const auto s_at = [&](std::size_t i) { return contour.length() * static_cast<double>(i) / static_cast<double>(n); };
    std::vector<double> overlap(n);
    for (std::size_t i = 0; i < n; ++i)
        overlap[i] = overlap_at(contour, s_at(i), ball_radius_mm);
    const auto blocked = [&](std::size_t i) { return overlap[i % n] > touching_mm; };
    BallPath path;
    UnreachedPlace place;
    for (std::size_t i = 0; i < n; ++i) {
        if (blocked(i)) {
            if (overlap[i] > place.depth_mm) place = {contour.position(s_at(i)), overlap[i]};
        } else {
            path.points.push_back(ball_point(contour, s_at(i), ball_radius_mm));
        }
        if (blocked(i) && !blocked(i + 1)) {
            if (place.depth_mm > reported_mm) path.unreached.push_back(place);
            place = {};
        }
        if (blocked(i) == blocked(i + 1)) continue;
        const double free = s_at(blocked(i) ? i + 1 : i), other = s_at(blocked(i) ? i : i + 1);
        path.points.push_back(ball_point(contour, last_free(contour, free, other, ball_radius_mm), ball_radius_mm));
    }
    path.points = forward_only(path.points);
    path.dense_step_mm = contour.length() / static_cast<double>(n);
    return path;
}

std::vector<BallPoint> sample_ball_path(const BallPath& path, const fitting::NominalSection& section,
                                        double ball_radius_mm, const SamplingOptions& options) {
    const auto& dense = path.points;
    const std::size_t n = dense.size();
    const auto length = path_length(dense);
    const auto step = local_steps(path, length, section, options);
    const double start = middle_of_suction(section);
    std::size_t first = 0;
    for (std::size_t i = 1; i < n; ++i) {
        if (section.curve().ahead(start, dense[i].contour_mm) < section.curve().ahead(start, dense[first].contour_mm))
            first = i;
    }
    // Steps taken up to each dense point, from the start on.
    std::vector<double> taken(n + 1, 0.0);
    for (std::size_t k = 0; k < n; ++k) {
        const std::size_t i = (first + k) % n;
        taken[k + 1] = taken[k] + (length[i + 1] - length[i]) * 2.0 / (step[i] + step[(i + 1) % n]);
    }
    const auto count = static_cast<std::size_t>(std::ceil(taken.back()));
    std::vector<BallPoint> points;
    points.reserve(count + options.overlap + 1);
    std::size_t k = 0;
    for (std::size_t j = 0; j < count; ++j) {
        const double target = taken.back() * static_cast<double>(j) / static_cast<double>(count);
        while (taken[k + 1] <= target)
            ++k;
        const std::size_t i = (first + k) % n;
        const double part = (target - taken[k]) / (taken[k + 1] - taken[k]);
        auto point = between(dense[i], dense[(i + 1) % n], part, section.curve(), ball_radius_mm, path.dense_step_mm);
        point.step_mm = step[i];
        if (points.empty() || point.centre_mm != points.back().centre_mm) points.push_back(point);
    }
    for (std::size_t j = 0; j <= options.overlap; ++j)
        points.push_back(points[j]);
    return points;
}

}  // namespace cmm::acquisition
