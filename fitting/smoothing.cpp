// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "fitting/closed_smoothing.hpp"
#include "fitting/knot_spacing.hpp"
#include "fitting/lack_of_fit.hpp"
#include "fitting/smoothing_joints.hpp"
#include "fitting/smoothing_system.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;

constexpr std::size_t points_needed = 12;
constexpr std::size_t least_spans = 10;
constexpr double anchor_sigmas = 12.0;  // distance of anchors
constexpr int refinements = 3;
constexpr int halvings = 8;               // of spans that do not follow their points
constexpr std::size_t fewest_halved = 4;  // points in such a span
constexpr double longest_period_mm = 1e7;

/// Noise along the normal, roughly and too large where the points are sparse: from the offsets of the points from the
/// chord of their neighbours.
double rough_sigma(std::span<const Vec2> points) {
    const std::size_t n = points.size();
    std::vector<double> off(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec2 &before = points[i > 0 ? i - 1 : n - 1], &after = points[i + 1 < n ? i + 1 : 0];
        const Vec2 chord = after - before;
        off[i] = std::abs(cross(points[i] - before, chord)) / std::max(chord.norm(), 1e-12);
    }
    return std::max(nth_smallest(off, n / 2) / (0.6745 * 1.2247), least_sigma_mm);
}

/// First parameters of points that go round once.
struct ChordLengths {
    std::vector<double> t;  // of each point
    double period = 0.0;
    std::vector<std::size_t> anchors;  // points that are clearly farther apart than the noise
};

/// Chord lengths between anchors that are clearly farther apart than the noise; the points between are projected.
ChordLengths chord_lengths(std::span<const Vec2> points, double sigma_mm) {
    ChordLengths out;
    std::vector<double>& t = out.t;
    std::vector<std::size_t>& anchors = out.anchors;
    const std::size_t n = points.size();
    const double apart = anchor_sigmas * sigma_mm;
    t.assign(n, 0.0);
    std::size_t anchor = 0;
    anchors.assign(1, 0);
    const auto project = [&](std::size_t from, std::size_t to, const Vec2& end) {
        const Vec2 chord = end - points[from];
        const double squared = chord.squaredNorm(), length = std::sqrt(squared);
        for (std::size_t k = from + 1; k < to; ++k) {
            const double share = squared > 0.0 ? (points[k] - points[from]).dot(chord) / squared : 0.0;
            t[k] = t[from] + std::clamp(share, 0.0, 1.0) * length;
        }
        return t[from] + length;
    };
    for (std::size_t i = 1; i < n; ++i) {
        if ((points[i] - points[anchor]).norm() < apart) continue;
        t[i] = project(anchor, i, points[i]);
        anchor = i;
        anchors.push_back(i);
    }
    out.period = project(anchor, n, points[0]);
    if (anchors.size() > 1 && (points[anchors.back()] - points[0]).norm() < apart) anchors.pop_back();
    return out;
}

/// Points all round: those that were measured, with those of the bridges between them.
class Course {
  public:
    Course(std::span<const Vec2> measured, std::span<const GapBridge> bridges) : points_(measured) {
        if (bridges.empty()) return;
        for (std::size_t i = 0; i < measured.size(); ++i) {
            add(measured[i], 0.0, i);
            for (; !bridges.empty() && bridges.front().before == i; bridges = bridges.subspan(1))
                for (const auto& [position, sigma_mm] : bridges.front().points)
                    add(position, sigma_mm, SmoothingSystem::supposed);
        }
        points_ = all_;
    }
    Course(const Course&) = delete;
    Course& operator=(const Course&) = delete;

    std::span<const Vec2> points() const { return points_; }

    /// Of the points in an order: 0 where they were measured; empty when all were.
    std::vector<double> supposed_sigma_mm(std::span<const std::size_t> order) const {
        std::vector<double> out;
        for (std::size_t i = 0; i < order.size() && !all_.empty(); ++i)
            out.push_back(sigma_mm_[order[i]]);
        return out;
    }
    /// Numbers of points become those of the measured ones.
    void number_as_measured(std::vector<std::size_t>& numbers) const {
        for (std::size_t i = 0; i < numbers.size() && !all_.empty(); ++i)
            numbers[i] = measured_[numbers[i]];
    }

  private:
    void add(const Vec2& point, double sigma_mm, std::size_t number) {
        all_.push_back(point);
        sigma_mm_.push_back(sigma_mm);
        measured_.push_back(number);
    }

    std::span<const Vec2> points_;
    std::vector<Vec2> all_;
    std::vector<double> sigma_mm_;
    std::vector<std::size_t> measured_;
};

/// A curve from its points to its joints.
class Smoothing {
  public:
    /// Points in order round and their first parameters; the points whose chords were measured.
    Smoothing(std::span<const Vec2> points, std::vector<double> t, const ChordLengths& chords,
              std::span<const Vec2> points_of_chords, double sigma_mm, std::span<const double> supposed_sigma_mm)
        : supposed_sigma_mm_(supposed_sigma_mm),
          system_(points, sigma_mm, supposed_sigma_mm),
          t_(std::move(t)),
          period_(chords.period) {
        for (const std::size_t i : chords.anchors) {
            anchors_.push_back(points_of_chords[i]);
            anchor_t_.push_back(chords.t[i]);
        }
        widest_.assign(anchors_.size(), period_);
    }

    core::Status run() {
        if (auto status = start(); !status) return status;
        if (auto status = fit(); !status) return status;
        // What joints do not explain is narrower than the spans.
        const std::vector<char> lacking = points_not_followed();
        if (std::find(lacking.begin(), lacking.end(), 1) == lacking.end()) return {};
        SmoothingSystem fitted = system_;
        const auto finer = start_finer(lacking);
        if (!finer) return tl::unexpected(finer.error());
        if (*finer) return fit();
        system_ = std::move(fitted);
        return {};
    }

    SmoothingSystem& system() { return system_; }
    std::vector<CurvatureStep>& joints() { return joints_; }
    SmoothingSystem::State& plain() { return plain_; }

  private:
    core::Status fit() {
        if (auto status = system_.refine(free_tunings); !status) return status;
        plain_ = system_.state();
        auto joints = place_joints(system_, plain_, {});
        if (!joints) return tl::unexpected(joints.error());
        joints_ = std::move(*joints);
        return {};
    }

    /// The start: least squares of the points themselves, hardly smoothed; with finer knots as long as the noise turns
    /// out to be smaller than was thought.
    core::Status start() {
        for (int attempt = 0;; ++attempt) {
            if (auto status = anew(); !status) return status;
            const double finer = span_turn(system_.sigma_mm());
            if (attempt == refinements || finer > 0.8 * turn_rad_) return {};
            turn_rad_ = finer;
        }
    }

    /// The same with finer knots where it does not follow points that are `lacking`. False when there are none finer.
    core::Result<bool> start_finer(std::span<const char> lacking) {
        bool any = false;
        for (int halving = 0; halving <= halvings; ++halving) {
            if (auto status = anew(); !status) return tl::unexpected(status.error());
            if (halving == halvings || !halve(lacking)) break;
            any = true;
        }
        return any;
    }

    /// Of those that were measured: where a point is only supposed, the curve is where it should be.
    std::vector<char> points_not_followed() const {
        std::vector<double> residuals = system_.residuals();
        for (std::size_t i = 0; i < supposed_sigma_mm_.size(); ++i)
            if (supposed_sigma_mm_[i] > 0.0) residuals[i] = 0.0;
        return not_followed(residuals, least_sigma_mm);
    }

    core::Status anew() {
        const std::size_t most = std::clamp(anchors_.size() * 2, least_spans, most_spans);
        return system_.start(graded_knots(anchors_, anchor_t_, period_, turn_rad_, most, widest_), t_);
    }

    /// Halves the spans that do not follow `lacking` points, as `widest_` of the anchors there. Are there any?
    bool halve(std::span<const char> lacking) {
        const std::vector<char> still = points_not_followed();
        const auto& breaks = system_.breaks();
        const auto last_not_above = [](std::span<const double> values, double value) {
            return static_cast<std::size_t>(std::upper_bound(values.begin() + 1, values.end(), value) -
                                            values.begin()) -
                   1;
        };
        std::vector<std::size_t> points_in(system_.spans(), 0), span_of;
        for (const double t : system_.parameters())
            ++points_in[span_of.emplace_back(last_not_above(breaks, t))];
        bool any = false;
        for (std::size_t i = 0; i < still.size(); ++i) {
            const std::size_t span = span_of[i], anchor = last_not_above(anchor_t_, system_.parameters()[i]);
            if (lacking[i] == 0 || still[i] == 0 || points_in[span] < fewest_halved) continue;
            for (const std::size_t k : {anchor, (anchor + 1) % anchor_t_.size()})
                widest_[k] = std::min(widest_[k], 0.5 * (breaks[span + 1] - breaks[span]));
            any = true;
        }
        return any;
    }

    std::span<const double> supposed_sigma_mm_;
    SmoothingSystem system_;
    SmoothingSystem::State plain_;  // before its joints
    std::vector<double> t_;
    std::vector<Vec2> anchors_;
    std::vector<double> anchor_t_;
    double period_;
    double turn_rad_ = usual_turn_rad;  // of a span
    std::vector<double> widest_;        // that a span at an anchor may be
    std::vector<CurvatureStep> joints_;
};

}  // namespace

core::Result<SmoothCurve> ClosedSmoothing::run(std::span<const Vec2> measured, std::span<const GapBridge> bridges) {
    if (measured.size() < points_needed)
        return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: needs " + std::to_string(points_needed) +
                                                            " points, got " + std::to_string(measured.size()));
    const double sigma_mm = rough_sigma(measured);
    const Course course(measured, bridges);
    const std::span<const Vec2> points = course.points();
    const ChordLengths chords = chord_lengths(points, sigma_mm);
    if (!std::isfinite(sigma_mm) || !(chords.period > 0.0 && chords.period < longest_period_mm))
        return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: the points span no plausible length");
    const std::size_t n = points.size();
    order_.resize(n);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    if (!std::is_sorted(chords.t.begin(), chords.t.end()))
        std::stable_sort(order_.begin(), order_.end(),
                         [&](std::size_t a, std::size_t b) { return chords.t[a] < chords.t[b]; });
    // Far from the origin a coordinate has fewer digits behind the point.
    origin_ = Vec2(std::round(points[0].x()), std::round(points[0].y()));
    points_.resize(n);
    std::vector<double> t(n);
    for (std::size_t i = 0; i < n; ++i) {
        points_[i] = points[order_[i]] - origin_;
        t[i] = chords.t[order_[i]];
    }
    supposed_sigma_mm_ = course.supposed_sigma_mm(order_);
    course.number_as_measured(order_);

    Smoothing smoothing(points_, std::move(t), chords, points, sigma_mm, supposed_sigma_mm_);
    if (auto status = smoothing.run(); !status) return tl::unexpected(status.error());
    plain_ = std::move(smoothing.plain());
    return std::move(smoothing.system()).finish(std::move(smoothing.joints()), order_, origin_, own_roughness_doubt);
}

core::Result<SmoothCurve> ClosedSmoothing::with(std::span<const ToldEdge> told) const {
    SmoothingSystem system(points_, plain_.sigma_mm, supposed_sigma_mm_);
    if (auto status = system.restore(plain_); !status) return tl::unexpected(status.error());
    auto joints = place_joints(system, plain_, told);
    if (!joints) return tl::unexpected(joints.error());
    return std::move(system).finish(std::move(*joints), order_, origin_, own_roughness_doubt);
}

core::Result<SmoothCurve> smooth_closed(std::span<const Vec2> points, std::span<const GapBridge> bridges) {
    return ClosedSmoothing().run(points, bridges);
}

}  // namespace cmm::fitting
