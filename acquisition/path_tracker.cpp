// SPDX-License-Identifier: Apache-2.0
#include "acquisition/path_tracker.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "fitting/vec2.hpp"

namespace cmm::acquisition {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using fitting::cross;
using fitting::left_of;

constexpr std::size_t first_points = 9, window_points = 7;
constexpr std::size_t rejections_to_doubt = 4;  // runs of bad points are up to three long
constexpr double noise_mm = 1.5e-3;
constexpr double slack_mm = 8e-3;      // what a good point may be off at no distance ...
constexpr double slack_per_mm = 0.12;  // ... and more with the distance, for the error of the heading
constexpr double tightest_concave_mm = 2.0;
constexpr double curvature_reach_mm = 0.6;
constexpr double rough_heading_rad = 0.5;
constexpr double start_window_mm = 2.0;  // the start counts as passed when it is nearer than this

}  // namespace

PathTracker::PathTracker(double ball_radius_mm, const Vector2d& heading)
    : radius_(ball_radius_mm), tangent_(heading.normalized()) {}

double PathTracker::Parabola::at(double x) const {
    return coefficients[0] + x * (coefficients[1] + x * coefficients[2]);
}

Vector2d PathTracker::Parabola::local(const Vector2d& p) const {
    return {(p - origin).dot(along), (p - origin).dot(left_of(along))};
}

Vector2d PathTracker::Parabola::tangent(double x) const {
    return (along + slope(x) * left_of(along)).normalized();
}

Vector2d PathTracker::Parabola::point(double x) const {
    return origin + x * along + at(x) * left_of(along);
}

PathTracker::Parabola PathTracker::fit(const std::vector<Weighted>& points, const Vector2d& origin,
                                       const Vector2d& along) {
    Parabola parabola{origin, along, Vector3d::Zero()};
    // Scaled to unit length: the normal equations of a parabola over tenths of a millimetre are badly balanced
    // otherwise.
    double scale = 0.0;
    for (const auto& p : points)
        scale = std::max(scale, std::abs(parabola.local(p.point).x()));
    if (scale <= 0.0) return parabola;
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Vector3d rhs = Vector3d::Zero();
    for (const auto& p : points) {
        const Vector2d q = parabola.local(p.point);
        const double x = q.x() / scale;
        const Vector3d row(1.0, x, x * x);
        normal += p.weight * row * row.transpose();
        rhs += p.weight * q.y() * row;
    }
    const Vector3d solution = normal.ldlt().solve(rhs);
    if (solution.allFinite()) parabola.coefficients = {solution[0], solution[1] / scale, solution[2] / (scale * scale)};
    return parabola;
}

void PathTracker::add(const Vector2d& centre) {
    if (!centre.allFinite() || (!raw_.empty() && (centre - raw_.back()).norm() < 1e-6)) return;
    raw_.push_back(centre);
    if (!ready_) {
        if (raw_.size() >= first_points) reacquire();
        return;
    }
    if (plausible(centre)) {
        rejected_ = 0;
        good_.push_back(centre);
        expect_turn(centre);
        update();
    } else if (++rejected_ >= rejections_to_doubt) {
        reacquire();
    }
}

bool PathTracker::plausible(const Vector2d& centre) const {
    const double x = (centre - position_).dot(tangent_), y = (centre - position_).dot(left_of(tangent_));
    if (x <= 0.0) return false;
    const double slack = slack_mm + slack_per_mm * x;
    const double inwards = x < radius_ ? radius_ - std::sqrt(radius_ * radius_ - x * x) : x;
    return y < inwards + slack + x * std::tan(std::min(doubt_rad_, 1.2)) &&
           y > -(x * x / (2.0 * tightest_concave_mm) + slack);
}

/// An edge that begins somewhere in the last step shows as a small deviation y inwards, but the arc behind it, as tight
/// as the ball, has turned by sqrt(2 y / r) already.
void PathTracker::expect_turn(const Vector2d& centre) {
    const double x = (centre - position_).dot(tangent_), y = (centre - position_).dot(left_of(tangent_));
    const double surprise = y - 0.5 * curvature_ * x * x;
    const double usual = 3.0 * noise_mm + 0.02 * x;
    doubt_rad_ = surprise > usual ? std::sqrt(2.0 * surprise / radius_) : 0.0;
}

void PathTracker::lost_contact() {
    if (!ready_ || rejected_ == 0) return;
    const Vector2d newest = raw_.back(), before = raw_[raw_.size() - 2];
    const Vector2d way = (newest - before).normalized();
    const bool turns_in = cross(tangent_, newest - position_) > 0.0 && cross(tangent_, way) > 0.0;
    if (turns_in) restart({before, newest}, way);
}

void PathTracker::regained_contact(const Vector2d& centre, const Vector2d& heading) {
    if (!ready_) return add(centre);
    raw_.push_back(centre);
    restart({centre}, heading.normalized());
}

/// Goes on with few points and a rough heading: in the finest steps and ready to believe turns.
void PathTracker::restart(std::vector<Vector2d> points, const Vector2d& heading) {
    good_ = std::move(points);
    rejected_ = 0;
    curvature_ = 0.0;
    sharpest_ = 1.0 / radius_;
    doubt_rad_ = rough_heading_rad;
    advance(good_.back(), heading);
}

std::vector<double> PathTracker::residuals(const Parabola& parabola, const std::vector<Vector2d>& points) {
    std::vector<double> off;
    for (const auto& p : points) {
        const Vector2d q = parabola.local(p);
        off.push_back(std::abs(q.y() - parabola.at(q.x())));
    }
    return off;
}

/// The points that agree with the parabola through three of them whose median residual is the least (Rousseeuw 1984).
std::vector<Vector2d> PathTracker::most_agreed(const std::vector<Vector2d>& points) const {
    const std::size_t count = points.size();
    std::vector<double> best;
    double best_median = std::numeric_limits<double>::max();
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i + 1; j < count; ++j) {
            for (std::size_t k = j + 1; k < count; ++k) {
                const auto trial = fit({{points[i], 1.0}, {points[j], 1.0}, {points[k], 1.0}}, points.back(), tangent_);
                const auto off = residuals(trial, points);
                auto sorted = off;
                std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count / 2), sorted.end());
                if (sorted[count / 2] >= best_median) continue;
                best_median = sorted[count / 2];
                best = off;
            }
        }
    }
    std::vector<Vector2d> agreed;
    for (std::size_t i = 0; i < best.size(); ++i) {
        if (best[i] <= std::max(5.0 * best_median, slack_mm)) agreed.push_back(points[i]);
    }
    return agreed;
}

/// Heading and position anew from the last points, whatever they are.
void PathTracker::reacquire() {
    const std::size_t count = ready_ ? std::min(raw_.size(), window_points) : raw_.size();
    good_ = most_agreed({raw_.end() - static_cast<std::ptrdiff_t>(count), raw_.end()});
    std::vector<Weighted> weighted;
    for (const auto& p : good_)
        weighted.push_back({p, 1.0});
    const auto parabola = fit(weighted, good_.back(), tangent_);
    if (!ready_) {
        const double x = parabola.local(raw_.front()).x();
        start_ = position_ = parabola.point(x);
        start_tangent_ = tangent_ = parabola.tangent(x);
        ready_ = true;
    }
    rejected_ = 0;
    doubt_rad_ = 0.0;
    advance(parabola.point(0.0), parabola.tangent(0.0));
    update();
}

/// After a good point: a short fit for the heading, a longer one for the curvature.
void PathTracker::update() {
    const Vector2d& newest = good_.back();
    std::vector<Weighted> few, many;
    double reach = 0.0;
    for (std::size_t k = 0; k < good_.size(); ++k) {
        const Vector2d& p = good_[good_.size() - 1 - k];
        reach = (p - newest).norm();
        if (k >= 5 && reach > curvature_reach_mm) break;
        constexpr std::array<double, 4> weights{1.0, 1.0, 0.5, 0.25};
        if (k < weights.size()) few.push_back({p, weights.at(k)});
        many.push_back({p, 1.0});
    }
    if (few.size() < 3) return;
    const auto near = fit(few, newest, tangent_), wide = fit(many, newest, tangent_);
    const auto bend = [](const Parabola& p) {
        return 2.0 * p.coefficients[2] / std::pow(1.0 + p.slope(0.0) * p.slope(0.0), 1.5);
    };
    const double step = (good_[good_.size() - 2] - newest).norm();
    // Three points say little about the curvature, but they say it at once: less their noise it bounds the step.
    const double doubt = 6.0 * noise_mm / std::max(step * step, 1e-6);
    const double limit = 1.0 / radius_;
    curvature_ = std::clamp(bend(wide), -1.0 / tightest_concave_mm, limit);
    sharpest_ =
        doubt_rad_ > 0.0 ? limit : std::min(limit, std::max(std::abs(curvature_), std::abs(bend(near)) - doubt));
    advance(near.point(0.0), near.tangent(0.0));
}

void PathTracker::advance(const Vector2d& position, const Vector2d& tangent) {
    const Vector2d before = position_ - start_, after = position - start_;
    length_ += (position - position_).norm();
    turned_ += std::atan2(cross(tangent_, tangent), tangent_.dot(tangent));
    position_ = position;
    tangent_ = tangent;
    // At the start the heading is known to a tenth of a radian or so, and a turn may end a little early.
    const bool turned_round = turned_ > 2.0 * std::numbers::pi - 0.7;
    const bool passed = before.dot(start_tangent_) < 0.0 && after.dot(start_tangent_) >= 0.0;
    if (turned_round && passed && after.norm() < start_window_mm) closed_ = true;
}

}  // namespace cmm::acquisition
