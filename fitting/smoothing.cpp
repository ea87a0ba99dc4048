// SPDX-License-Identifier: Apache-2.0
#include "fitting/smoothing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>

#include "fitting/curvature_joints.hpp"
#include "fitting/knot_spacing.hpp"
#include "fitting/least_squares.hpp"
#include "fitting/roughness.hpp"
#include "fitting/statistics.hpp"

namespace cmm::fitting {
namespace {

using core::ErrorCode;
using Four = std::array<double, 4>;
using Five = std::array<double, 5>;

constexpr std::size_t points_needed = 12;
constexpr std::size_t least_spans = 10, most_spans = 512;
constexpr double least_sigma_mm = 2e-5;  // nothing below is resolved
constexpr double anchor_sigmas = 12.0;   // distance of anchors
constexpr double turn_rad = 0.1;         // that a span holds at 1 um noise
constexpr double common_sigma_mm = 1e-3;
constexpr double finest_turn = 0.25;  // of that, where there is hardly any
constexpr int refinements = 3;
constexpr double start_ridge = 1e-3;  // weight of the third differences in the start curve, in points
constexpr double start_roughness = 1e-6;
/// exp(sqrt(2)): the logarithm of a variance that one degree of freedom tells has the variance 2, and a knot and its
/// neighbours tell hardly more of theirs. The uncertainty is that of a curve so much rougher than is likeliest.
constexpr double roughness_doubt = 4.11;
constexpr std::size_t sharing_knots = 2;  // to either side, that share a scale of the roughness
constexpr double student_freedom = 0.3;
constexpr int tunings = 7, joint_tunings = 3, last_tunings = 2;
constexpr double knot_share = 0.02;  // of a span: how near the knots of a joint are
constexpr double joint_grid_mm = 1e-3;
constexpr double least_joint_speed = 0.3, most_joint_turn_rad = 0.2;
constexpr double most_joint_variance = 4.0;  // of the curve there, over that of a point
constexpr int most_shifts = 4;               // of the joints
constexpr double lasting_step_share = 0.2;   // of the ramp's
constexpr double joint_stray_sigmas = 2.0;   // of a joint's shift: the step of the curvature times its square
constexpr double least_speed = 0.05;  // of the parameter, which is nearly a length; below it the curve has a cusp
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

/// A joint's place is known to some hundredths of a millimetre: what rounding does to it must not move the curve.
double on_grid(double t) {
    return std::round(t / joint_grid_mm) * joint_grid_mm;
}

class Smoother {
  public:
    explicit Smoother(std::span<const Vec2> points) : input_(points) {}

    /// Without joints the curvature of the curve is continuous everywhere.
    core::Status run(bool with_joints) {
        sigma_ = rough_sigma(input_);
        parametrise_by_chords();
        if (!std::isfinite(sigma_) || !(period_ > 0.0 && period_ < longest_period_mm))
            return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: the points span no plausible length");
        sort_points();
        if (auto status = start(); !status) return status;
        if (auto status = refine(tunings); !status) return status;
        const double without = largest_variance();
        if (with_joints) {
            measure_jumps();
            joints_ = find_curvature_joints(breaks_, slope_, length_, sigma_);
            for (CurvatureJoint& joint : joints_)
                joint.t = on_grid(joint.t);
        }
        if (joints_.empty()) {
            measure();
            if (auto status = refine(last_tunings); !status) return status;
        }
        if (auto status = place_joints(); !status) return status;
        measure();
        if (!joints_are_known() || (!joints_.empty() && largest_variance() > most_joint_variance * without))
            return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: the points do not determine a joint");
        return {};
    }

    SmoothCurve result() && {
        SmoothCurve out;
        const std::size_t n = t_.size();
        out.parameter.resize(n);
        out.residual.resize(n);
        out.leverage.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            const std::size_t to = order_[i];
            out.parameter[to] = t_[i];
            out.residual[to] = residual_[i];
            const Four& b = basis_[i];
            double sum = 0.0;
            for (std::size_t a = 0; a < 4; ++a) {
                const auto& row = inverse_[wrapped(span_[i] + a)];
                sum += b[a] * b[a] * row[0];
                for (std::size_t c = a + 1; c < 4; ++c)
                    sum += 2.0 * b[a] * b[c] * row[c - a];
            }
            out.leverage[to] = std::clamp(sum, 0.0, 1.0);
        }
        out.sigma_mm = sigma_;
        out.freedom = freedom_;
        for (const CurvatureJoint& joint : joints_)
            out.joints.push_back({joint.t, joint.step});
        if (solve(roughness_doubt)) normal_.invert(inverse_);
        std::vector<Four> covariance(spans_);
        for (std::size_t k = 0; k < spans_; ++k)
            for (std::size_t m = 0; m < 4; ++m)
                covariance[k][m] = sigma_ * sigma_ * inverse_[k][m];
        std::vector<CubicBasis> bases;
        for (std::size_t k = 0; k < spans_; ++k)
            bases.push_back(least_squares_.basis(k));
        out.noise = CurveNoise(curve_.breaks(), std::move(bases), std::move(covariance),
                               std::make_shared<const BandSolver<4>>(std::move(normal_)), sigma_);
        out.curve = std::move(curve_);
        return out;
    }

  private:
    std::size_t wrapped(std::size_t control) const { return control < spans_ ? control : control - spans_; }

    /// So many solutions, each with the noise and the roughness that the one before tells; then the curve moves.
    core::Status refine(int count) {
        for (int tuning = 0; tuning < count; ++tuning) {
            if (!solve()) return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: singular system");
            tune();
        }
        move();
        return {};
    }

    core::Status place_joints() {
        if (joints_.empty()) return {};
        if (auto status = open_joints(); !status) return status;
        for (int shift = 0;; ++shift) {
            if (auto status = refine(joint_tunings); !status) return status;
            if (!joints_are_smooth())
                return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: the curve turns back at a joint");
            if (shift == most_shifts || joints_.empty() || (shift > 0 && !joints_strayed_)) return {};
            if (auto status = shift_joints(); !status) return status;
        }
    }

    /// Knots where the curvature may jump, in place of the ramps; the roughness of a ramp is no roughness of the curve.
    core::Status open_joints() {
        std::vector<Roughness::Run> ramps;
        for (const CurvatureJoint& joint : joints_)
            ramps.push_back({joint.first_span - 1, joint.last_span});
        return set_joints(breaks_, ramps);
    }

    /// Of the controls across the curve, by the latest solution, mm^2.
    double largest_variance() const {
        double largest = 0.0;
        for (std::size_t k = 0; k < spans_; ++k)
            largest = std::max(largest, inverse_[k][0]);
        return sigma_ * sigma_ * largest;
    }

    /// Whether the points tell the curve at its joints, from the latest solution.
    bool joints_are_known() const {
        return std::all_of(joint_knots_.begin(), joint_knots_.end(), [&](const KnotCluster& knots) {
            const Four b = least_squares_.basis(knots.first).at(1.0);
            double sum = 0.0;
            for (std::size_t a = 0; a < 4; ++a)
                for (std::size_t c = a; c < 4; ++c)
                    sum += (c > a ? 2.0 : 1.0) * b[a] * b[c] * inverse_[wrapped(knots.first + a)][c - a];
            return sum < most_joint_variance;
        });
    }

    /// Between its knots a curve has no room to turn; where it does all the same, a bad point has it on a leash.
    bool joints_are_smooth() const {
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            const Vec2 before = curve_.jet(breaks_[joint_knots_[j].first]).d1;
            const Vec2 behind = curve_.jet(breaks_[joint_knots_[j].first + 2]).d1;
            const double slower = std::min(before.norm(), behind.norm());
            if (!(slower > least_joint_speed) || !(std::abs(turn_angle(before, behind)) < most_joint_turn_rad))
                return false;
        }
        return true;
    }

    /// Each joint goes to where the tangents of both sides agree. One whose step has hardly anything of the ramp that
    /// it was made from is none.
    core::Status shift_joints() {
        std::vector<double> breaks;
        std::vector<CurvatureJoint> kept;
        std::size_t next = 0;
        joints_strayed_ = false;
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            CurvatureJoint joint = joints_[j];
            const KnotCluster& knots = joint_knots_[j];
            for (; next < knots.first; ++next)
                breaks.push_back(breaks_[next]);
            next = knots.first + 3;
            const double before = curve_.jet(joint.t - knots.apart).curvature();
            const double behind = curve_.jet(joint.t + knots.apart).curvature();
            const double between = curve_.jet(joint.t).curvature();
            const double turn = knots.apart * (between - 0.5 * (before + behind)), step = behind - before;
            if (step * joint.ramp_step < lasting_step_share * joint.ramp_step * joint.ramp_step) {
                breaks.push_back(joint.t);
                joints_strayed_ = true;
                continue;
            }
            const double most = 0.5 * joint.width_mm;
            const double last = joint.t;
            joint.t = on_grid(std::clamp(joint.t - std::clamp(turn / step, -most, most), joint.from_t, joint.to_t));
            joint.step = step;
            const double strayed = joint.t - last;
            if (std::abs(step) * strayed * strayed > joint_stray_sigmas * sigma_) joints_strayed_ = true;
            kept.push_back(joint);
        }
        joints_ = std::move(kept);
        breaks.insert(breaks.end(), breaks_.begin() + static_cast<std::ptrdiff_t>(next), breaks_.end());
        return set_joints(breaks, {});
    }

    core::Status set_joints(const std::vector<double>& plain, const std::vector<Roughness::Run>& ramps) {
        std::vector<double> places;
        for (const CurvatureJoint& joint : joints_)
            places.push_back(joint.t);
        auto breaks = breaks_with_joints(plain, places, 3, knot_share, joint_knots_);
        std::vector<std::size_t> from(breaks.size() - 1);
        std::size_t old = 0;  // knot k is break k + 1
        for (std::size_t k = 0; k < from.size(); ++k) {
            const double t = breaks[k + 1];
            while (old + 1 < spans_ && std::abs(breaks_[old + 2] - t) <= std::abs(breaks_[old + 1] - t))
                ++old;
            from[k] = old;
        }
        roughness_.carry_over(from, ramps);
        for (std::size_t j = 0; j < joints_.size(); ++j) {
            const CurvatureJoint& joint = joints_[j];
            const auto& [first, apart] = joint_knots_[j];
            // A joint elsewhere by d turns the tangent by step d: the change of slope at the middle knot is
            // 2 step d / apart^2.
            const double turn = 2.0 * joint.step * 0.5 * joint.width_mm / (apart * apart * std::sqrt(apart));
            roughness_.hold(first - 1, std::numeric_limits<double>::infinity());
            roughness_.hold(first, turn * turn);
            roughness_.hold(first + 1, std::numeric_limits<double>::infinity());
        }
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

    double width(std::size_t k) const { return breaks_[k + 1] - breaks_[k]; }

    /// Chord lengths between anchors that are clearly farther apart than the noise; the points between are projected.
    void parametrise_by_chords() {
        const std::size_t n = input_.size();
        const double apart = anchor_sigmas * sigma_;
        t_.assign(n, 0.0);
        std::size_t anchor = 0;
        anchors_.assign(1, 0);
        const auto project = [&](std::size_t from, std::size_t to, const Vec2& end) {
            const Vec2 chord = end - input_[from];
            const double squared = chord.squaredNorm(), length = std::sqrt(squared);
            for (std::size_t k = from + 1; k < to; ++k) {
                const double share = squared > 0.0 ? (input_[k] - input_[from]).dot(chord) / squared : 0.0;
                t_[k] = t_[from] + std::clamp(share, 0.0, 1.0) * length;
            }
            return t_[from] + length;
        };
        for (std::size_t i = 1; i < n; ++i) {
            if ((input_[i] - input_[anchor]).norm() < apart) continue;
            t_[i] = project(anchor, i, input_[i]);
            anchor = i;
            anchors_.push_back(i);
        }
        period_ = project(anchor, n, input_[0]);
        if (anchors_.size() > 1 && (input_[anchors_.back()] - input_[0]).norm() < apart) anchors_.pop_back();
    }

    void sort_points() {
        const std::size_t n = t_.size();
        order_.resize(n);
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        if (!std::is_sorted(t_.begin(), t_.end()))
            std::stable_sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return t_[a] < t_[b]; });
        for (const std::size_t i : anchors_) {
            anchor_points_.push_back(input_[i]);
            anchor_t_.push_back(t_[i]);
        }
        std::vector<double> t(n);
        points_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            t[i] = t_[order_[i]];
            points_[i] = input_[order_[i]];
        }
        chord_t_ = std::move(t);
        span_.resize(n);
        basis_.resize(n);
        residual_.resize(n);
    }

    /// Least squares of the points themselves, hardly smoothed; with finer knots as long as the noise turns out to be
    /// smaller than was thought.
    core::Status start() {
        double turn = turn_rad;
        for (int attempt = 0;; ++attempt) {
            if (auto status = fit_start(turn); !status) return status;
            const double finer = turn_rad * std::clamp(std::cbrt(sigma_ / common_sigma_mm), finest_turn, 1.2);
            if (attempt == refinements || finer > 0.8 * turn) return {};
            turn = finer;
        }
    }

    core::Status fit_start(double turn) {
        const std::size_t most = std::clamp(anchor_points_.size() * 2, least_spans, most_spans);
        t_ = chord_t_;
        breaks_ = graded_knots(anchor_points_, anchor_t_, period_, turn, most);
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
        double squares = 0.0;
        for (const double r : residual_)
            squares += r * r;
        const double n = static_cast<double>(points_.size());
        sigma_ =
            std::max(std::sqrt(squares / std::max(n - 0.5 * static_cast<double>(spans_), 0.25 * n)), least_sigma_mm);
        std::vector<double> variance(spans_);
        for (std::size_t k = 0; k < spans_; ++k)
            variance[k] = start_roughness / std::pow(width(k), 5);
        roughness_.reset(variance, sharing_knots, student_freedom);
        return {};
    }

    /// Feet and residuals of the points, jumps of the curvature's slope at the knots, and how both answer to a normal
    /// displacement of the controls.
    void measure() {
        const auto& pieces = curve_.pieces();
        const double first = breaks_.front(), last = breaks_.back();
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
                                          -0.01 * period_, 0.01 * period_);
            if (t < first) t += period_;
            if (t >= last) t -= period_;
            t_[i] = t;
            span = span_of(t);
            span_[i] = static_cast<std::uint32_t>(span);
            const double u = t - breaks_[span];
            const Vec2 apart = points_[i] - at(span, u, d1);
            residual_[i] = cross(apart, d1) / std::max(d1.norm(), 1e-12);
            basis_[i] = least_squares_.basis(span).at(u / width(span));
        }
        measure_jumps();
        sum_points();
    }

    void measure_jumps() {
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
    void sum_points() {
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
    bool solve(double times = 1.0) {
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
    void tune() {
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
    void move() {
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

    void set_curve() {
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

    std::span<const Vec2> input_;
    std::vector<std::size_t> order_;  // sorted position -> input index
    std::vector<Vec2> points_;        // in the order of their first parameters, like the next four
    std::vector<double> chord_t_, t_, residual_;
    std::vector<std::uint32_t> span_;
    std::vector<Four> basis_;
    std::vector<std::size_t> anchors_;
    std::vector<Vec2> anchor_points_;
    std::vector<double> anchor_t_;
    double period_ = 0.0;
    double sigma_ = common_sigma_mm;
    double freedom_ = 0.0;

    std::size_t spans_ = 0;
    std::vector<double> breaks_;
    LeastSquaresSpline least_squares_;
    std::vector<Vec2> controls_;
    PiecewiseCubic curve_;
    std::vector<double> length_, slope_, jump_;  // of the curvature by length: per span, and scaled jump per knot
    std::vector<Four> slope_row_;
    std::vector<Five> jump_row_;
    std::vector<std::array<Four, 4>> gram_;
    std::vector<Four> moment_;
    double residual_squares_ = 0.0;
    BandSolver<4> normal_;
    std::vector<BandSolver<4>::Row> inverse_;
    std::vector<double> displacement_, moved_, uncertain_;
    Roughness roughness_;
    std::vector<CurvatureJoint> joints_;
    std::vector<KnotCluster> joint_knots_;
    bool joints_strayed_ = false;  // in the latest shift, so far that another one follows
};

}  // namespace

core::Result<SmoothCurve> smooth_closed(std::span<const Vec2> points) {
    if (points.size() < points_needed)
        return core::fail(ErrorCode::fit_not_evaluable, "smoothing spline: needs " + std::to_string(points_needed) +
                                                            " points, got " + std::to_string(points.size()));
    Smoother smoother(points);
    if (smoother.run(true)) return std::move(smoother).result();
    Smoother plain(points);
    if (const auto status = plain.run(false); !status) return tl::unexpected(status.error());
    return std::move(plain).result();
}

}  // namespace cmm::fitting
